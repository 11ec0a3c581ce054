// SPDX-License-Identifier: GPL-3.0-or-later
// hapt: the command line tool. One file a sub-command.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <iostream>

#include "clients/hapt_commands.h"
#include "proto/version.h"

namespace {

constexpr int kExitFailed = 1;
constexpr int kExitUsage = 2;

/// What was typed wrongly, in one line. A help text is no mistake: exit code 0.
int explain(const CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == 0) return app.exit(error);
  const std::vector<std::string> strays = app.remaining();
  const bool no_command = app.get_subcommands().empty() && !strays.empty();
  const std::string what = no_command ? "no command '" + strays.front() + "'" : error.what();
  const std::string of =
      app.get_subcommands().empty() ? "" : app.get_subcommands().front()->get_name() + " ";
  std::cerr << "hapt: " << what << "; see hapt " << of << "--help\n";
  return kExitUsage;
}

int run(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::RuntimeError& error) {
    return error.get_exit_code();
  } catch (const CLI::ParseError& error) {
    return explain(app, error);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app{"hapt: start, watch, record and judge haptic sessions"};
  app.require_subcommand(1);
  app.set_version_flag("--version", haptic::version());
  haptic::add_demo_command(app);
  haptic::add_replay_command(app);
  haptic::add_top_command(app);
  haptic::add_record_command(app);
  haptic::add_export_command(app);
  haptic::add_eval_command(app);
  haptic::add_bake_command(app);
  haptic::add_bench_command(app);
  haptic::add_selftest_command(app);
  haptic::add_torture_command(app);
  haptic::add_control_commands(app);
  const int code = run(app, argc, argv);
  // a script must not take half a table for a whole one
  if (!std::cout.flush() || std::fflush(stdout) != 0) {
    std::cerr << "hapt: standard output cannot be written; the figures are not whole\n";
    return kExitFailed;
  }
  return code;
} catch (const std::exception& error) {
  std::fprintf(stderr, "hapt: %s\n", error.what());
  return kExitFailed;
}
