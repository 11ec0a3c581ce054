// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace CLI {  // NOLINT(readability-identifier-naming): of the library
class App;
}

/// The sub-commands of `hapt`, one file each. Each function adds its command and what it does to
/// the app; the work runs while the app parses. It throws std::exception (one line for people, exit
/// code 1), or CLI::RuntimeError where the exit code is all there is to say.
namespace haptic {

void add_bake_command(CLI::App& app);
void add_bench_command(CLI::App& app);
void add_control_commands(CLI::App& app);
void add_demo_command(CLI::App& app);
void add_eval_command(CLI::App& app);
void add_export_command(CLI::App& app);
void add_record_command(CLI::App& app);
void add_replay_command(CLI::App& app);
void add_selftest_command(CLI::App& app);
void add_top_command(CLI::App& app);
void add_torture_command(CLI::App& app);

}  // namespace haptic
