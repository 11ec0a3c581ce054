// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "device-io/emulator/firmware.h"

namespace haptic {

/// The session that is judged: a hand on an emulated WoodenHaptics presses into the half space
/// z < 0 of the device's frame B, which pushes it up.
struct ForceRules {
  double stiffness = 500;         // of the spring [N/m]
  double max_force = 3.6;         // [N]
  double max_damping = 2;         // of the passivity controller [N·s/m]
  double slew = 200;              // of a force that grows by itself [N/s]
  double soft_start = 0.1;        // [s]
  int64_t tick_ns = 1'000'000;    // of the servo
  int64_t zero_ns = 20'000'000;   // stated: zero so long after a fault that closes the force
  int64_t hold_ns = 100'000'000;  // stated: contacts are rendered in full no longer than this
  int64_t fade_ns = 50'000'000;   // stated: and fade over this
  int64_t doubt_ns = 20'000'000;  // stated: a pose is held this long where the answers do not match
};

/// A time during which nobody on this machine could run [ns].
struct Stall {
  int64_t begin_ns, end_ns;
};

/// How long the machine stood still between two instants [ns]; the stalls do not overlap.
int64_t held_up(std::span<const Stall> stalls, int64_t from_ns, int64_t to_ns);

/// What a fault may do to the force.
enum class Effect {
  kLies,     // contact pushes with what is not there: within limits, and no fast rise
  kLimits,   // only what always holds: within limits, never more than the wall, no fast rise
  kNothing,  // the hand feels the spring as before, command by command
  kFade,     // contacts grow old: hold, then fade, then zero until it is over; back by a ramp
  kZero,     // zero at once and until it is over, then soft start
  kSilence,  // the device itself is away; on its return zero first, then soft start
};

/// A fault that was put into a session. Times are CLOCK_MONOTONIC, as in the emulator's log.
struct JudgedFault {
  Effect effect = Effect::kNothing;
  int64_t begin_ns = 0;            // when it had been done
  int64_t over_ns = 0;             // when its cause was gone; 0: not known, as with a dead servo
  int64_t soft_ns = 0;             // where a new servo's soft start began; 0: with the last zero
  std::vector<Stall> stalls = {};  // what a witness measured; stated times are longer by as much
  bool is_misled = false;          // the device says what is not so, and nobody can know it at once
  int64_t from_ns = 0;  // commands before it are context: what breaks there is not this fault's
};

enum class ForceBreach {
  kTooStrong,    // above the largest force
  kBeyondWall,   // more than the spring at the deepest of the last answers, and the damper
  kRise,         // rises faster than the hand pushes and the slew limit allows
  kChanged,      // not the spring, where a fault may change nothing
  kLateFade,     // more than old contacts may still give
  kLateZero,     // not zero in time, or never
  kEarlyReturn,  // force again before the fault was over
  kHardStart,    // back faster than the soft start
  kLostRecord,   // the emulator's own log has a gap: nothing is proven there
};
inline constexpr size_t kForceBreaches = 9;

std::string_view name_of(ForceBreach breach);

/// The first breach of its kind: what was received when, and what was allowed [N].
struct ForceViolation {
  ForceBreach breach;
  int64_t t_ns;
  double force;
  double allowed;
};

struct ForceVerdict {
  std::vector<ForceViolation> violations;  // one of a kind at most
  std::optional<int64_t> zero_after_ns;    // from the begin to the first zero; nothing: never zero
  size_t excused = 0;  // kNothing: commands not judged, because the machine had stood still
};

/// Depth of the tip below the wall that the server knew of when it sent a command [m].
double answered_depth(const EmulatorRecord& record);

/// Whether a command is the spring at the depth that the server knew, give or take the passivity
/// controller's damper at `speed` [m/s] and the step of the currents.
bool is_wall(const ForceRules& rules, const EmulatorRecord& command, double speed);

/// Judges what the device received around one fault. The records are those of the emulator, in
/// order, from some ticks before the fault (pressing) to its end. A rise is lawful where it is at
/// most k·(growth of the depth that the encoders saw) + damper + slew·dt.
ForceVerdict judge_force(const ForceRules& rules, std::span<const EmulatorRecord> records,
                         const JudgedFault& fault);

/// When the hand first felt the spring again after from_ns: the time of the first of ten commands
/// in a row that are the wall of a pressing hand. Nothing: not yet.
std::optional<int64_t> whole_again(const ForceRules& rules, std::span<const EmulatorRecord> records,
                                   int64_t from_ns);

/// Where the emulator itself stood still: it writes a record every 10 ms at least, and what is
/// longer is its own delay.
std::vector<Stall> emulator_stalls(std::span<const EmulatorRecord> records);

/// Both witnesses: stalls in order of time, none overlapping.
std::vector<Stall> merge_stalls(std::span<const Stall> a, std::span<const Stall> b);

}  // namespace haptic
