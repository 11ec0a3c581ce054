// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/hapt/run_hapt.h"

#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>

#include "proto/os/message.h"
#include "proto/os/version.h"

namespace haptic {
namespace {

constexpr int kExitFailed = 1;
constexpr int kExitUsage = 2;

}  // namespace

int run_hapt(int argc, char** argv, const std::function<void(Command&)>& add_commands) try {
  // exceeding the file size limit becomes a reported write error instead of a signal
  std::signal(SIGXFSZ, SIG_IGN);
  CommandLine line("hapt: start, watch, record and judge haptic sessions");
  line.require_subcommand();
  line.version(version());
  add_commands(line);
  const int code = line.read(argc, argv, "hapt", kExitUsage).value_or(0);
  // a script must not take an incomplete table for a complete one
  if (!std::cout.flush() || std::fflush(stdout) != 0) {
    std::cerr << "hapt: standard output cannot be written; the figures are not whole\n";
    return kExitFailed;
  }
  return code;
} catch (const std::exception& error) {
  std::fprintf(stderr, "hapt: %s\n", one_line(error.what()).c_str());
  return kExitFailed;
}

}  // namespace haptic
