// SPDX-License-Identifier: GPL-3.0-or-later
// hapt bench: measures this machine, in alternation with a peer library.
#include <array>

#include "clients/hapt/commands.h"
#include "clients/lab/support/measurement.h"

namespace haptic {

#define BENCH(name, help) Prepare bench_##name;
#include "clients/lab/bench/benches.def"

void add_bench_command(Command& app) {
  const std::array benches{
#define BENCH(name, help) Measurement{#name, help, bench_##name},
#include "clients/lab/bench/benches.def"
  };
  Command command = add_elsewhere(app, "bench");
  command.require_subcommand();
  command.example("hapt bench ring --rounds 3");
  add_measurements(command, "hapt bench", benches);
}

}  // namespace haptic
