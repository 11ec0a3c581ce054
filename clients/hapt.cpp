// SPDX-License-Identifier: GPL-3.0-or-later
// hapt: the command line tool. One file a sub-command.
#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>

#include "clients/hapt_commands.h"

int main(int argc, char** argv) {
  CLI::App app{"hapt: start, watch, record and judge haptic sessions"};
  app.require_subcommand(1);
  app.set_version_flag("--version", HAPTICD_VERSION);
  haptic::add_demo_command(app);
  haptic::add_replay_command(app);
  haptic::add_top_command(app);
  haptic::add_record_command(app);
  haptic::add_export_command(app);
  haptic::add_eval_command(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::RuntimeError& error) {
    return error.get_exit_code();
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const std::exception& error) {
    std::cerr << "hapt: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
