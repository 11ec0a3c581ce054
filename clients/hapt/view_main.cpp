// SPDX-License-Identifier: GPL-3.0-or-later
// haptic-view: the command of `hapt` that shows a session to browsers, with the web server it
// needs.
#include "clients/hapt/commands.h"
#include "clients/hapt/run_hapt.h"

int main(int argc, char** argv) {
  return haptic::run_hapt(argc, argv, [](haptic::Command& app) { haptic::add_view_command(app); });
}
