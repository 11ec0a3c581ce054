// SPDX-License-Identifier: GPL-3.0-or-later
// hapt bench: figures of this machine beside those of peers.
#include <CLI/CLI.hpp>

#include "clients/bench_jitter.h"
#include "clients/hapt_commands.h"

namespace haptic {

void add_bench_command(CLI::App& app) {
  CLI::App* bench = app.add_subcommand("bench", "Measure this machine, beside peers");
  bench->require_subcommand(1);
  add_bench_jitter(*bench);
}

}  // namespace haptic
