// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "clients/lab/torture/session.h"
#include "proto/os/realtime.h"

namespace haptic {

/// Faults that can be injected into a running session.
enum class FaultKind {
#define FAULT(id, ...) id,
#include "clients/lab/torture/faults.def"
};

/// The session that faults are inflicted on, and the random numbers that set how long stops last.
struct Torturer {
  TortureSession& session;
  std::mt19937_64 random;

  int64_t between(int64_t least_ns, int64_t most_ns);
};

/// Times of an inflicted fault, for the check. It begins when it is known to have happened, because
/// this program may be stalled before that.
struct Inflicted {
  int64_t begin_ns = 0;
  int64_t from_ns = 0;  // before it was injected
  int64_t over_ns = 0;
  int64_t soft_ns = 0;           // first tick of a new servo
  int64_t whole_from_ns = 0;     // commands from here on count for recovery
  int64_t recovery_from_ns = 0;  // start of the recovery time
  bool recovers = true;          // false: the force never left, no recovery time
  int64_t recovered_ns = 0;      // end of recovery if not given by the force; 0: it is
  int64_t waited_ns = 0;         // for a processor, by the restarted process
  std::vector<std::string> problems = {};
  std::string left_out = {};  // why it was not injected; empty if it was
};

/// Properties of a kind of fault, and the function that inflicts it.
struct FaultInfo {
  FaultKind kind;
  std::string_view name;
  int share;
  Effect effect;
  Inflicted (*inflict)(Torturer& torturer);
  int64_t goal_ns = 0;                     // documented time to recovery; 0: none
  int64_t zero_ns = ForceRules{}.zero_ns;  // documented time to zero force, if the effect is zero
  bool is_misled = false;                  // the device reports false data
  bool is_of_six = false;                  // of a device that turns only
  bool is_of_given = false;                // of the client that moves the block only
  bool is_without_given = false;           // a block of a client is let go of, too
  // the process that dies: hapticd delays the restart of one that lived less than ten seconds
  const WriterSeen& (TortureSession::*restarts)() const = nullptr;
};

/// True if a fault can be injected into such a session.
constexpr bool is_possible(const FaultInfo& info, const TortureOptions& options) {
  return (!info.is_of_six || options.six) && (!info.is_of_given || options.given) &&
         (!info.is_without_given || !options.given);
}

/// Only a broken session takes this long.
inline constexpr int64_t kFaultPatienceNs = 20 * kNsPerSecond;
/// "150 ms".
std::string milliseconds(int64_t ns);

/// In the order of FaultKind.
std::span<const FaultInfo> all_faults();
const FaultInfo& info_of(FaultKind kind);

}  // namespace haptic
