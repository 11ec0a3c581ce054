// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <istream>
#include <string>

#include "clients/library/histogram.h"

namespace haptic {

/// Result of cyclictest (Debian rt-tests), the usual tool for wake-up latency.
struct CyclictestRun {
  Histogram late;  // [ns]; longer than 1 ms is stored as just above 1 ms
  uint64_t over_100us = 0;
  uint64_t over_1ms = 0;
  std::string problem;  // why there are no figures; empty if there are
};

/// Reads the output of cyclictest -q -N -h 1000000.
CyclictestRun parse_cyclictest(std::istream& output);

/// Runs one thread at FIFO 80 on the core, 1 kHz, memory locked. The idle states of the system stay
/// as they are (--default-system), because the servo does not change them either.
CyclictestRun run_cyclictest(int seconds, int core);

}  // namespace haptic
