// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>

#include "clients/lockstep/lockstep.h"
#include "clients/log/given_replay.h"
#include "contact/bake/session.h"
#include "proto/config/command_line.h"
#include "proto/config/config.h"

namespace haptic {

/// A session file on the virtual clock, as it is named on a command line.
struct OfflineSession {
  std::string config = "bunny.toml", trace;
  double seconds = 20;  // of a hand that is not recorded
  LockstepOptions lockstep;
  bool without_clients = false;  // what clients gave in the recording of the hand is left out

  std::string file() const;
  /// The session with its hand. Throws ConfigError, also where the hand is a real device's.
  SessionConfig load() const;
};

/// Options --config, --trace, --for, and those of the lockstep.
void add_offline_session(Command& command, OfflineSession& session);
/// Options --contact-period and --contact-latency.
void add_lockstep(Command& command, LockstepOptions& lockstep);

/// "contact every tick, one tick late".
std::string pace_of(const LockstepOptions& lockstep);

/// The number of ticks a hand plays: all of a recording, the given time of any other.
uint64_t ticks_of(const SessionConfig& config, double seconds);

/// A session in lockstep with its own hand, baked shapes and all. Throws MeshError.
struct PlayedSession {
  explicit PlayedSession(const SessionConfig& config, const LockstepOptions& options = {});
  BakedSession baked;
  ContactShapes shapes;
  std::unique_ptr<Device> hand;
  Lockstep lockstep;
};

/// A session in lockstep in which clients give again what they gave in the recording of its hand:
/// each frame comes before the first tick that is not earlier than the instant at which it came.
class GivenInLockstep {
 public:
  /// A hand that is no recording with clients: the session as it is. Throws McapError as
  /// GivenReplay does.
  explicit GivenInLockstep(const SessionConfig& config);

  /// Gives what is due, and makes one tick; false as Lockstep::step.
  bool step(Lockstep& session);

 private:
  std::unique_ptr<GivenReplay> replay_;  // null: nothing is given
};

/// "00ab34…": a hash as text.
std::string in_hex(uint64_t hash);

}  // namespace haptic
