// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <istream>
#include <string>

#include "clients/library/histogram.h"

namespace haptic {

/// What cyclictest (Debian rt-tests), the usual measure of wake-up latency, found.
struct CyclictestRun {
  Histogram late;           // [ns]; beyond 1 ms only that it was beyond
  uint64_t over_100us = 0;  // of all
  uint64_t over_1ms = 0;
  std::string problem;  // why there are no figures; empty: there are
};

/// Reads the output of cyclictest -q -N -h 1000000.
CyclictestRun parse_cyclictest(std::istream& output);

/// One thread at FIFO 80 on the core, 1 kHz, memory locked. The system's idle states are left as
/// they are (--default-system), as the servo leaves them.
CyclictestRun run_cyclictest(int seconds, int core);

}  // namespace haptic
