// SPDX-License-Identifier: GPL-3.0-or-later
// hapt: the command line tool, one file per sub-command.
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>
#include <string>

#include "clients/hapt/commands.h"
#include "clients/hapt/lab_commands.h"
#include "clients/hapt/run_hapt.h"
#include "proto/ipc/process.h"
#include "proto/os/programs.h"
#include "proto/os/source_tree.h"

namespace haptic {
namespace {

/// The program of a command; empty: it is one of this program.
std::string program_of(const std::string& word) {
  const auto command = std::find_if(kLabCommands.begin(), kLabCommands.end(),
                                    [&](const LabCommand* one) { return word == one->name; });
  return command == kLabCommands.end() ? "" : (*command)->program;
}

/// Decides by the first word that names a command.
std::string program_for(const Command& app, int argc, char** argv) {
  const auto is_command = [&](const char* word) { return app.has_subcommand(word); };
  char** const end = argv + argc;
  char** const command = std::find_if(std::min(argv + 1, end), end, is_command);
  return command == end ? "" : program_of(*command);
}

/// Replaces this process by another program with the same arguments.
[[noreturn]] void become(const std::string& program, char** argv) {
  const std::string path = own_folder() + "/" + program;
  execv(path.c_str(), argv);
  throw std::runtime_error(cannot_start(path, errno));
}

/// In the order of `hapt --help`.
void add_commands(Command& app) {
  const auto add_of_lab = [&](const LabCommand& lab) { app.subcommand(lab.name, lab.help); };
  add_demo_command(app);
  add_replay_command(app);
  add_of_lab(kViewCommand);
  add_top_command(app);
  add_record_command(app);
  add_info_command(app);
  add_diff_command(app);
  add_clearance_command(app);
  add_recover_command(app);
  add_export_command(app);
  add_of_lab(kEvalCommand);
  add_of_lab(kZwidthCommand);
  add_of_lab(kPassivityCommand);
  add_of_lab(kBodeCommand);
  add_devices_command(app);
  add_doctor_command(app);
  add_bake_command(app);
  add_of_lab(kBenchCommand);
  add_of_lab(kSelftestCommand);
  add_of_lab(kTortureCommand);
  add_control_commands(app);
}

}  // namespace
}  // namespace haptic

int main(int argc, char** argv) {
  return haptic::run_hapt(argc, argv, [&](haptic::Command& app) {
    haptic::add_commands(app);
    const std::string program = haptic::program_for(app, argc, argv);
    if (!program.empty()) haptic::become(program, argv);
  });
}
