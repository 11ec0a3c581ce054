// SPDX-License-Identifier: GPL-3.0-or-later
// hapt status, config, stop, arm, disarm, pause, resume, clear-fault, set: one request line to
// hapticd, one answer.
#include <iostream>
#include <memory>
#include <sstream>
#include <stdexcept>

#include "clients/hapt/commands.h"
#include "proto/config/command_line.h"
#include "proto/ipc/control_socket.h"
#include "proto/os/message.h"

namespace haptic {
namespace {

struct ControlOptions {
  std::string session, key, value;
};

void say(const ControlOptions& options, const std::string& line) {
  constexpr std::string_view kError = "error: ";
  const std::string answer = say_to_session(options.session, line);
  if (answer.starts_with(kError)) throw std::runtime_error(answer.substr(kError.size()));
  // the answer to `config` is a session file of many lines
  std::istringstream lines(answer);
  for (std::string one; std::getline(lines, one);) {
    std::cout << printable(one, kLongestAnswer) << '\n';
  }
}

void add_word(Command& app, const std::string& word, const std::string& help) {
  const auto options = std::make_shared<ControlOptions>();
  Command command = app.subcommand(word, help);
  command.option("--session", options->session, "which one; default: the only one running");
  command.action([options, word] { say(*options, word); });
}

}  // namespace

void add_control_commands(Command& app) {
  add_word(app, "status", "What a session and its processes are doing, as JSON");
  add_word(app, "config", "The session file that a session was started with");
  add_word(app, "stop", "End a session");
  add_word(app, "arm", "Let the hand feel forces");
  add_word(app, "disarm", "Take the force away until armed again");
  add_word(app, "pause", "Zero force until resumed");
  add_word(app, "resume", "Go on after a pause");
  add_word(app, "clear-fault", "Allow force again after a fault, once the handle is still");
  const auto options = std::make_shared<ControlOptions>();
  Command command =
      app.subcommand("set", "Change a parameter, it ramps over 200 ms; or the renderer");
  command.option("key", options->key, "stiffness, damping, time-scale or renderer").required();
  command.option("value", options->value, "with its unit, as \"500 N/m\"; or a name").required();
  command.option("--session", options->session, "which one; default: the only one running");
  command.action([options] { say(*options, "set " + options->key + " " + options->value); });
}

}  // namespace haptic
