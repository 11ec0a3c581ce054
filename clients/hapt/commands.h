// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

/// The sub-commands of `hapt`, one file each. Each function adds its command and action to the app;
/// the action runs during parsing. It throws std::exception (one line for people, exit code 1; an
/// InputError 2), or ExitCode if the code alone is enough.
namespace haptic {

class Command;

void add_bake_command(Command& app);
void add_bench_command(Command& app);
void add_bode_command(Command& app);
void add_clearance_command(Command& app);
void add_control_commands(Command& app);
void add_demo_command(Command& app);
void add_devices_command(Command& app);
void add_diff_command(Command& app);
void add_doctor_command(Command& app);
void add_eval_command(Command& app);
void add_export_command(Command& app);
void add_info_command(Command& app);
void add_passivity_command(Command& app);
void add_record_command(Command& app);
void add_recover_command(Command& app);
void add_replay_command(Command& app);
void add_selftest_command(Command& app);
void add_top_command(Command& app);
void add_torture_command(Command& app);
void add_view_command(Command& app);
void add_zwidth_command(Command& app);

}  // namespace haptic
