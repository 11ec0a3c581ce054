// SPDX-License-Identifier: GPL-3.0-or-later
// hapt-lab: the commands of `hapt` that measure and check, with the libraries they compare with.
#include "clients/hapt/commands.h"
#include "clients/hapt/run_hapt.h"

int main(int argc, char** argv) {
  return haptic::run_hapt(argc, argv, [](haptic::Command& app) {
    haptic::add_eval_command(app);
    haptic::add_bench_command(app);
    haptic::add_selftest_command(app);
    haptic::add_torture_command(app);
    haptic::add_zwidth_command(app);
    haptic::add_passivity_command(app);
    haptic::add_bode_command(app);
  });
}
