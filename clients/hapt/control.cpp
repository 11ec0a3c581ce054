// SPDX-License-Identifier: GPL-3.0-or-later
// hapt status, config, stop, arm, disarm, pause, resume, clear-fault, set, lead: one request line
// to hapticd, one answer; of lead one after the other.
#include <algorithm>
#include <array>
#include <iostream>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "clients/hapt/commands.h"
#include "clients/hapt/options.h"
#include "clients/hapt/session_choice.h"
#include "proto/ipc/control_socket.h"
#include "proto/os/message.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

struct ControlOptions {
  SessionChoice session;
  std::string hand;  // empty: all
  std::string key, value;
  bool json = false;
  bool force = false;
};

std::string ask(const std::string& session, const std::string& line) {
  const std::string answer = say_to_session(session, line);
  if (answer.starts_with(kMistakeAnswer)) throw InputError(answer.substr(kMistakeAnswer.size()));
  if (answer.starts_with(kFailedAnswer)) {
    throw std::runtime_error(answer.substr(kFailedAnswer.size()));
  }
  return answer;
}

void say(const ControlOptions& options, const std::string& line) {
  const std::string answer = ask(once_up(options.session), line);
  // the answer to `config` is a session file of many lines
  std::istringstream lines(answer);
  for (std::string one; std::getline(lines, one);) {
    std::cout << printable(one, kLongestAnswer) << '\n';
  }
}

void add_named_hand(Command& command, std::string& hand) {
  command.option("--hand NAME", hand, "one hand of several, by name or number")
      .check([](const std::string& typed) {
        return typed.find_first_of(" \n") == std::string::npos && !typed.empty()
                   ? ""
                   : "a hand is named by one word, as left or 0";
      });
}

/// The request, for one hand where it is named.
std::string addressed(const std::string& hand, const std::string& line) {
  return hand.empty() ? line : "hand " + hand + " " + line;
}

/// A word to all hands or to one.
void add_word_to_hands(Command& app, const std::string& word, const std::string& help) {
  const auto options = std::make_shared<ControlOptions>();
  Command command = app.subcommand(word, help);
  add_session(command, options->session);
  add_named_hand(command, options->hand);
  command.example("hapt " + word);
  command.action([options, word] { say(*options, addressed(options->hand, word)); });
}

void add_word(Command& app, const std::string& word, const std::string& help) {
  const auto options = std::make_shared<ControlOptions>();
  Command command = app.subcommand(word, help);
  add_session(command, options->session);
  command.example("hapt " + word);
  command.action([options, word] { say(*options, word); });
}

void add_status(Command& app) {
  const auto options = std::make_shared<ControlOptions>();
  Command command = app.subcommand("status", "Print what a session and its processes are doing");
  add_session(command, options->session);
  add_json(command, options->json);
  command.example("hapt status --session bunny");
  command.action([options] { say(*options, options->json ? "status" : "status text"); });
}

void add_set(Command& app) {
  const auto options = std::make_shared<ControlOptions>();
  Command command = app.subcommand(
      "set", "Change a parameter (it ramps over 200 ms), the renderer or its solver");
  command
      .option(
          "KEY", options->key,
          "stiffness, damping, rotational-stiffness, rotational-damping, time-scale, renderer or "
          "solver")
      .required();
  command.option("VALUE", options->value, "with its unit, as \"500 N/m\"; or a name").required();
  add_session(command, options->session);
  add_named_hand(command, options->hand);
  command.flag("--force", options->force,
               "even if the coupling is stiffer than the device can hold");
  command.example("hapt set stiffness \"500 N/m\"");
  command.example("hapt set solver penalty-dynamics");
  command.action([options] {
    const std::string line =
        "set " + options->key + " " + options->value + (options->force ? " --force" : "");
    say(*options, addressed(options->hand, line));
  });
}

struct LeadOptions {
  SessionChoice session;
  std::string hand;
  std::array<double, 3> place{};    // [m]
  std::vector<double> orientation;  // w x y z; empty: as at rest
  double duration = 2;              // [s]
};

/// Repeats the command as a viewer does; without it the servo ends the lead.
void lead(const LeadOptions& options) {
  constexpr int64_t kPeriodNs = kNsPerSecond / 60;
  const std::string& session = once_up(options.session);
  std::string line = "lead";
  for (const double x : options.place) line += " " + number_text(x);
  for (const double x : options.orientation) line += " " + number_text(x);
  const int64_t begin_ns = now_ns();
  const auto end_ns = begin_ns + static_cast<int64_t>(options.duration * 1e9);
  line = addressed(options.hand, line);
  for (int64_t t_ns = begin_ns; t_ns < end_ns; t_ns += kPeriodNs) {
    ask(session, line);
    sleep_until(std::min(t_ns + kPeriodNs, end_ns));
  }
  std::cout << ask(session, addressed(options.hand, "release")) << '\n';
}

void add_lead(Command& app) {
  add_command<LeadOptions>(
      app, "lead", "Lead the simulated hand to a place in the scene", lead,
      [](Command& command, LeadOptions& options) {
        constexpr std::array kNames{"X", "Y", "Z"};
        for (size_t i = 0; i < kNames.size(); ++i) {
          command
              .quantity(kNames[i], options.place[i], Dimension::kLength,
                        {-kMostLength, kMostLength},
                        "where the tool is led to, in metres or with a unit", "m")
              .required();
        }
        command
            .number("--orientation QW QX QY QZ", options.orientation, {-1, 1},
                    "of the tool in the scene, where the handle can turn (default: as at rest)")
            .expected(4);
        add_duration(command, "--for TIME", options.duration, "how long (default: 2 s)");
        add_session(command, options.session);
        add_named_hand(command, options.hand);
        command.example("hapt lead 0.02 0 0.05 --for 5s");
      });
}

}  // namespace

void add_control_command(Command& app) {
  add_status(app);
  add_set(app);
  add_lead(app);
  add_word_to_hands(app, "pause", "Pause force output");
  add_word_to_hands(app, "resume", "Resume force output");
  add_word_to_hands(app, "arm", "Enable force output");
  add_word_to_hands(app, "disarm", "Disable force output until armed again");
  add_word_to_hands(app, "clear-fault", "Clear a latched fault, once the handle is still");
  add_word(app, "config", "Print the session file that a session was started with");
  add_word(app, "stop", "End a session");
}

}  // namespace haptic
