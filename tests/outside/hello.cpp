// SPDX-License-Identifier: GPL-3.0-or-later
#include <iostream>

#include "clients/hapt/commands.h"

namespace haptic {

void add_hello_command(Command& app) {
  Command command = app.subcommand("hello", "Say hello");
  command.action([] { std::cout << "hello\n"; });
}

}  // namespace haptic
