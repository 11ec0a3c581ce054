// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <variant>

#include "proto/ipc/attachments.h"
#include "servo/hapticd/child_process.h"
#include "servo/hapticd/log.h"
#include "servo/hapticd/restart_policy.h"

namespace haptic {

/// The phase of a child's life. A child that was told to end is in its phase until it
/// has ended.
enum class Phase {
  kWaiting,   // there is none: the next one starts at start_at_ns
  kStarting,  // prepares meshes or brings the device home, for as long as that takes
  kReady,     // of a spare: prepared, sleeps until contact is dead
  kWaking,    // was a ready spare, and is contact now: nothing is left to prepare
  kRunning,   // has offered its segment: its loop runs
};

/// A part that a process plays in a session: sim, contact, servo, or the spare of contact. A child
/// that ends is followed by another one.
struct Role {
  static constexpr int64_t kNever = std::numeric_limits<int64_t>::max();
  using Events =
      std::variant<RingSource<&SimChannels::events>, RingSource<&ContactChannels::events>,
                   RingSource<&ServoChannels::events>>;

  struct Life {
    Phase phase = Phase::kWaiting;
    int64_t started_ns = 0;
    Silence silence = {};
    Pulse pulse = Pulse::kFine;
  };
  /// The reason why starting it again cannot help, and hapticd's exit code then.
  struct Hopeless {
    int exit_code;
    std::string why;
  };

  const char* program;
  const char* name;
  SegmentId id;
  uint32_t hand;  // of a servo or a contact
  int64_t period_ns;
  int64_t (*delay_ns)(int deaths_in_a_row, int64_t lived_ns);
  std::optional<Events> events = {};  // of its segment; none: a spare has not offered it
  uint64_t told_lost = 0;
  ChildProcess child = {};
  uint64_t generation = 0;
  Life life = {};
  int64_t start_at_ns = kNever;  // while it waits
  int deaths_in_a_row = 0;
  int deaths_unborn = 0;  // in a row, before its loop ran
  bool ever_ran = false;

  /// Header of its segment while the child's loop runs; else null.
  const SegmentHeader* running() const;
  /// Kills a child that hangs. To be called regularly, held_up_ns later than planned.
  void watch_pulse(HapticdLog& log, int64_t t_ns, int64_t held_up_ns);
  void write_events(HapticdLog& log);
  /// Notes a death with this wait status; none: another start may help.
  std::optional<Hopeless> bury(int status);
  /// Puts the next start off after a death or an attempt; returns for how long [ns].
  int64_t put_off(int64_t t_ns);
};

}  // namespace haptic
