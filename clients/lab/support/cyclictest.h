// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <istream>
#include <string>

#include "clients/library/histogram.h"

namespace haptic {

/// How late the wakes of a loop are.
struct Lateness {
  Histogram late;  // [ns]
  uint64_t over_100us = 0, over_1ms = 0;
};

/// Result of cyclictest (Debian rt-tests), the usual tool for wake-up latency; what is later than
/// 1 ms is stored as just above it.
struct CyclictestRun : Lateness {
  std::string problem;  // why there are no figures; empty if there are
};

/// Reads the output of cyclictest -q -N -h 1000000.
CyclictestRun parse_cyclictest(std::istream& output);

/// Runs one thread at FIFO 80 on the core, 1 kHz, memory locked. The idle states of the system stay
/// as they are (--default-system), because the servo does not change them either.
CyclictestRun run_cyclictest(int seconds, int core);

}  // namespace haptic
