// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <memory>
#include <string>

#include "proto/config/command_line.h"

/// The sub-commands of `hapt`, one file each. Each function adds its command and action to the app;
/// the action runs during parsing. It throws std::exception (one line for people, exit code 1; an
/// InputError 2), or ExitCode if the code alone is enough.
namespace haptic {

#define COMMAND(name) void add_##name##_command(Command& app);
#define COMMAND_OF(name, program, help) COMMAND(name)
#include "clients/hapt/commands.def"

/// A command that another program holds.
struct CommandElsewhere {
  std::string_view name, program, help;
};
inline constexpr std::array kCommandsElsewhere{
#define COMMAND(name)
#define COMMAND_OF(name, program, help) CommandElsewhere{#name, program, help},
#include "clients/hapt/commands.def"
};

/// Adds a command of this name: `declare` adds its options and examples, and its action is to `run`
/// with what they were set to.
template <typename Options>
void add_command(Command& app, const std::string& name, const std::string& help,
                 void (*run)(const Options&), void (*declare)(Command&, Options&)) {
  const auto options = std::make_shared<Options>();
  Command command = app.subcommand(name, help);
  declare(command, *options);
  command.action([options, run] { run(*options); });
}

/// Adds one of them as `hapt --help` shows it.
Command add_elsewhere(Command& app, std::string_view name);

}  // namespace haptic
