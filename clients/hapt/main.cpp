// SPDX-License-Identifier: GPL-3.0-or-later
// hapt: the command line tool, one file per sub-command.
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <span>
#include <stdexcept>
#include <string>

#include "clients/hapt/commands.h"
#include "clients/hapt/run_hapt.h"
#include "proto/ipc/process.h"
#include "proto/os/programs.h"
#include "proto/os/source_tree.h"

namespace haptic {
namespace {

/// The program of the first word that names a command; empty: this one, or no word names one.
std::string program_for(const Command& app, std::span<char*> words) {
  for (const char* word : words) {
    const auto row = std::ranges::find(kCommandsElsewhere, word, &CommandElsewhere::name);
    if (row != kCommandsElsewhere.end()) return std::string(row->program);
    if (app.has_subcommand(word)) break;
  }
  return "";
}

std::string path_of(std::string_view program) {
  return own_folder() + "/" + std::string(program);
}

/// Replaces this process by another program with the same arguments.
[[noreturn]] void become(const std::string& program, char** argv) {
  const std::string path = path_of(program);
  execv(path.c_str(), argv);
  throw std::runtime_error(cannot_start(path, errno));
}

/// Adds every command of this program, and those of another where that is installed: the packages
/// leave the laboratory out.
void add_commands(Command& app) {
#define COMMAND(name) add_##name##_command(app);
#define COMMAND_OF(name, program, help) \
  if (access(path_of(program).c_str(), X_OK) == 0) add_elsewhere(app, #name);
#include "clients/hapt/commands.def"
}

}  // namespace
}  // namespace haptic

int main(int argc, char** argv) {
  return haptic::run_hapt(argc, argv, [&](haptic::Command& app) {
    haptic::add_commands(app);
    const std::span words(argv + std::min(argc, 1), argv + argc);
    const std::string program = haptic::program_for(app, words);
    if (!program.empty()) haptic::become(program, argv);
  });
}
