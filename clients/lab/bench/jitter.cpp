// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/measurement.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "clients/lab/support/forked_process.h"
#include "clients/lab/support/jitter_rows.h"
#include "proto/config/command_line.h"
#include "proto/os/progress.h"

namespace haptic {
namespace {

struct Options {
  int pairs = 5;
  double seconds = 15;
  std::optional<size_t> core;
};

/// The last allowed core by default, because the first serves the interrupts.
size_t choose_core(const std::optional<size_t>& wanted) {
  const std::vector<size_t> allowed = allowed_processors();
  if (!wanted && !allowed.empty()) return allowed.back();
  const size_t core = wanted.value_or(0);
  if (std::find(allowed.begin(), allowed.end(), core) != allowed.end()) return core;
  throw std::runtime_error("bench jitter: this process may not use core " + std::to_string(core) +
                           "; choose another with --core (taskset -cp $$ lists them)");
}

/// Runs cyclictest beside the same witness as the servo's loop, so that both share the core alike.
CyclictestRun run_witnessed_cyclictest(const WakeOptions& wake) {
  std::thread witness([&] { measure_witness(wake); });
  CyclictestRun run = run_cyclictest(static_cast<int>(wake.seconds), wake.core);
  witness.join();
  return run;
}

void check_pinned(const WakeRun& run) {
  if (run.pin_errno == 0) return;
  throw std::runtime_error(std::string("bench jitter: the loop could not be kept on its core: ") +
                           std::strerror(run.pin_errno) + "; choose another with --core");
}

std::vector<JitterRound> measure(const Options& options) {
  const auto core = static_cast<int>(choose_core(options.core));
  std::vector<JitterRound> rounds;
  Progress progress("measuring pairs", options.pairs);
  for (int i = 0; i < options.pairs; ++i) {
    // cyclictest accepts no fractions
    WakeOptions wake{.seconds = std::ceil(options.seconds), .core = core};
    JitterRound round;
    // the order alternates, so that a drift of the machine favours neither
    if (i % 2 == 1) round.peer = run_witnessed_cyclictest(wake);
    round.sleep = measure_witnessed_wakes(wake);
    if (i % 2 == 0) round.peer = run_witnessed_cyclictest(wake);
    wake.spin_ns = kHybridSpinNs;
    round.hybrid = measure_wakes(wake);
    for (const WakeRun* run : {&round.sleep.servo, &round.sleep.witness, &round.hybrid}) {
      check_pinned(*run);
    }
    rounds.push_back(std::move(round));
    progress.step();
  }
  return rounds;
}

void all_rows(const Options& options, const Rows& all) {
  const std::vector<JitterRound> rounds = measure(options);
  const std::string problem = peer_problem_of(rounds);
  if (!problem.empty()) std::cerr << "hapt: " << problem << '\n';
  const RealtimeReport& rights = rounds.front().sleep.servo.rights;
  if (rights.fifo_errno != 0) {
    std::cerr << "hapt: " << rights.explain() << "; no goal is applied\n";
  }
  add_jitter_rows(rounds, all);
}

}  // namespace

/// Wake-up lateness of the servo's clock, in alternation with cyclictest.
Measured bench_jitter(Command& command) {
  const auto options = std::make_shared<Options>();
  add_counts(command,
             {{"--pairs", &options->pairs, "rounds of servo, cyclictest and hybrid", 1, 1000}});
  command
      .quantity("--for", options->seconds, Dimension::kTime, {1, 3600},
                "of each window, rounded up to whole seconds", "s")
      .show_default();
  command.option("--core", options->core, "on which they all run").show_default("the last allowed");
  return measured(all_rows, options);
}

}  // namespace haptic
