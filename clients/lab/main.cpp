// SPDX-License-Identifier: GPL-3.0-or-later
// hapt-lab: the commands of `hapt` that measure and check, with the libraries they compare with.
#include "clients/hapt/commands.h"
#include "clients/hapt/run_hapt.h"

namespace haptic {
namespace {

void add_lab_commands(Command& app) {
#define COMMAND(name)
#define COMMAND_OF(name, program, help) \
  if constexpr (std::string_view(program) == "hapt-lab") add_##name##_command(app);
#include "clients/hapt/commands.def"
}

}  // namespace
}  // namespace haptic

int main(int argc, char** argv) {
  return haptic::run_hapt(argc, argv, haptic::add_lab_commands);
}
