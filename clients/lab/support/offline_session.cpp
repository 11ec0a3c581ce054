// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/offline_session.h"

#include <cstdio>
#include <limits>

#include "clients/hapt/options.h"
#include "proto/config/devices.h"
#include "proto/os/session_file.h"
#include "proto/os/text.h"

namespace haptic {

std::string OfflineSession::file() const {
  return find_session_file(config);
}

SessionConfig OfflineSession::load() const {
  SessionConfig loaded = load_config(file());
  if (!trace.empty()) use_trace(loaded, trace);
  if (row_of(loaded.device.kind).has_node()) {
    throw std::runtime_error(file() +
                             ": a real device cannot run on a virtual clock; name a recorded hand "
                             "with --trace, or another --config");
  }
  return loaded;
}

void add_lockstep(Command& command, LockstepOptions& lockstep) {
  add_counts(command, {{"--contact-period", &lockstep.contact_period,
                        "servo ticks between two contact steps", 1, 1000},
                       {"--contact-latency", &lockstep.contact_latency,
                        "ticks until an answer is visible; 0: within the tick", 0, 1000}});
}

void add_offline_session(Command& command, OfflineSession& session) {
  add_config(command, session.config).show_default();
  command.option("--trace FILE", session.trace, "recorded hand instead of the configured device");
  add_duration(command, "--for", session.seconds, "how long a simulated hand explores")
      .show_default();
  add_lockstep(command, session.lockstep);
}

std::string pace_of(const LockstepOptions& lockstep) {
  const auto ticks = [](uint32_t n) { return n == 1 ? "tick" : std::to_string(n) + " ticks"; };
  const std::string delay =
      lockstep.contact_latency == 1 ? "one tick" : ticks(lockstep.contact_latency);
  return "contact every " + ticks(lockstep.contact_period) + ", " + delay + " late";
}

uint64_t ticks_of(const SessionConfig& config, double seconds) {
  if (row_of(config.device.kind).is_recorded) return std::numeric_limits<uint64_t>::max();
  return static_cast<uint64_t>(seconds * config.servo_rate);
}

PlayedSession::PlayedSession(const SessionConfig& config, const LockstepOptions& options)
    : baked(bake_session(config)),
      shapes(baked.shapes()),
      hand(open_device(config.device)),
      lockstep(config, shapes, *hand, options) {}

GivenInLockstep::GivenInLockstep(const SessionConfig& config) {
  const std::string path(view(config.device.replay.path));
  if (!row_of(config.device.kind).is_recorded || !is_mcap_file(path)) return;
  replay_ = std::make_unique<GivenReplay>(path, config, config.device.replay.from);
  if (replay_->is_empty()) replay_.reset();
}

bool GivenInLockstep::step(Lockstep& session) {
  if (replay_ == nullptr) return session.step();
  if (!replay_->has_begun()) replay_->begin(session.next_t_ns());
  GivenAgain due;
  while (replay_->next(session.next_t_ns(), due)) {
    if (due.is_frame) {
      session.give(due.client, due.frame);
    } else if (due.generation == 0) {
      session.leave(due.client);
    }
  }
  // sim sees the frame of the tick before in this one
  if (session.frame().t_ns != 0) replay_->see(kFirstHand, session.frame());
  return session.step();
}

std::string in_hex(uint64_t hash) {
  return formatted("%016llx", static_cast<unsigned long long>(hash));
}

}  // namespace haptic
