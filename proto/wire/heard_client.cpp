// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/heard_client.h"

#include "proto/math/assert.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

constexpr HoldLimits kHold{20 * kMs, 500 * kMs};  // three times the median period
constexpr int64_t kLeastBetweenNs = 2 * kMs;      // of the frames that are looked at

/// The age of what has not come yet.
Age closed_age() {
  Age age;
  age.closed = true;
  age.weight = 0;
  return age;
}

}  // namespace

HeardClient::HeardClient() : age_(closed_age()) {}

bool HeardClient::follow(uint64_t generation) {
  if (generation == generation_) return false;
  const uint64_t n_taken = n_taken_;
  *this = {};
  n_taken_ = n_taken;
  generation_ = generation;
  return true;
}

bool HeardClient::is_due(int64_t t_ns) const {
  return generation_ != 0 && t_ns - looked_ns_ >= kLeastBetweenNs;
}

bool HeardClient::look_at(uint64_t generation, const GivenFrame& given, int64_t t_ns) {
  if (generation != generation_ || !is_due(t_ns)) return false;
  looked_ns_ = t_ns;
  return given.seq != last_seq_;
}

GiverRefusal HeardClient::wrong_time(const GivenFrame& given, int64_t t_ns) const {
  const bool is_wrong =
      given.seq <= last_seq_ || given.t_ns <= taken_ns_ || given.t_ns > t_ns + kClientFutureNs;
  return is_wrong ? GiverRefusal::kBackInTime : GiverRefusal::kNone;
}

void HeardClient::conclude(const GivenFrame& given, GiverRefusal why, int64_t t_ns) {
  if (given.seq > last_seq_) last_seq_ = given.seq;
  refusal_ = why;
  if (why != GiverRefusal::kNone) {
    ++refused_;
    return;
  }
  ++n_taken_;
  taken_ns_ = given.t_ns;
  came_ns_ = t_ns;
}

double HeardClient::weigh(int64_t t_ns, double dt) {
  HAPTIC_ASSERT(dt > 0);
  const Arrival arrival{came_ns_ != 0, n_taken_, came_ns_, true};
  return haptic::weigh(age_, arrival, t_ns, dt, kHold).weight;
}

GiverState HeardClient::report(uint32_t client, int64_t t_ns) const {
  GiverState out{};
  out.seq = last_seq_;
  out.t_ns = taken_ns_;
  out.period_ns = age_.median_ns;
  out.refused = refused_;
  out.weight = age_.weight;
  out.client = client;
  out.refusal = static_cast<uint32_t>(refusal_);
  const bool is_attached = generation_ != 0;
  if (is_attached) out.flags |= kGiverAttached;
  if (is_attached && t_ns - came_ns_ > hold_ns(age_, kHold)) out.flags |= kGiverLate;
  return out;
}

}  // namespace haptic
