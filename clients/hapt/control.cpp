// SPDX-License-Identifier: GPL-3.0-or-later
// hapt status, config, stop, arm, disarm, pause, resume, clear-fault, set: one request line to
// hapticd, one answer.
#include <iostream>
#include <memory>
#include <sstream>
#include <stdexcept>

#include "clients/hapt/commands.h"
#include "clients/hapt/options.h"
#include "proto/ipc/control_socket.h"
#include "proto/os/message.h"

namespace haptic {
namespace {

struct ControlOptions {
  std::string session, key, value;
  bool json = false;
};

void say(const ControlOptions& options, const std::string& line) {
  const std::string answer = say_to_session(options.session, line);
  if (answer.starts_with(kMistakeAnswer)) throw InputError(answer.substr(kMistakeAnswer.size()));
  if (answer.starts_with(kFailedAnswer)) {
    throw std::runtime_error(answer.substr(kFailedAnswer.size()));
  }
  // the answer to `config` is a session file of many lines
  std::istringstream lines(answer);
  for (std::string one; std::getline(lines, one);) {
    std::cout << printable(one, kLongestAnswer) << '\n';
  }
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
  Command command =
      app.subcommand("set", "Change a parameter (it ramps over 200 ms) or the renderer");
  command
      .option(
          "KEY", options->key,
          "stiffness, damping, rotational-stiffness, rotational-damping, time-scale or renderer")
      .required();
  command.option("VALUE", options->value, "with its unit, as \"500 N/m\"; or a name").required();
  add_session(command, options->session);
  command.example("hapt set stiffness \"500 N/m\"");
  command.action([options] { say(*options, "set " + options->key + " " + options->value); });
}

}  // namespace

void add_control_commands(Command& app) {
  add_status(app);
  add_set(app);
  add_word(app, "pause", "Pause force output");
  add_word(app, "resume", "Resume force output");
  add_word(app, "arm", "Enable force output");
  add_word(app, "disarm", "Disable force output until armed again");
  add_word(app, "clear-fault", "Clear a latched fault, once the handle is still");
  add_word(app, "config", "Print the session file that a session was started with");
  add_word(app, "stop", "End a session");
}

}  // namespace haptic
