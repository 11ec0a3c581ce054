// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/hapt/run_hapt.h"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>

#include "clients/hapt/commands.h"
#include "proto/math/assert.h"

namespace haptic {

Command add_elsewhere(Command& app, std::string_view name) {
  const auto row = std::ranges::find(kCommandsElsewhere, name, &CommandElsewhere::name);
  HAPTIC_ASSERT(row != kCommandsElsewhere.end());
  return app.subcommand(std::string(row->name), std::string(row->help));
}

int run_hapt(int argc, char** argv, const std::function<void(Command&)>& add_commands) try {
  // exceeding the file size limit becomes a reported write error instead of a signal
  std::signal(SIGXFSZ, SIG_IGN);
  CommandLine line("hapt", "Start, watch, record and evaluate haptic sessions.");
  line.require_subcommand();
  line.footer("'hapt help COMMAND' explains a command.");
  line.example("hapt demo peg --for 10s");
  add_commands(line);
  const int code = line.read(argc, argv).value_or(0);
  // a script must not take an incomplete table for a complete one
  if (!std::cout.flush() || std::fflush(stdout) != 0) {
    std::cerr << "hapt: standard output cannot be written; the figures are incomplete\n";
    return kExitFailed;
  }
  return code;
} catch (const std::exception& error) {
  return report_failure("hapt", error);
}

}  // namespace haptic
