// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "proto/wire/age.h"
#include "proto/wire/wire.h"

namespace haptic {

inline constexpr int64_t kClientFutureNs = 5'000'000;  // what the clock of a client may be ahead
// of a statement: a client that is farther behind gives nothing that is still so
inline constexpr int64_t kOldestGivenNs = 500'000'000;

/// A client as a process that uses what it gives has heard it: which of its frames count, which
/// were refused, and the weight of what it gives by its age. It is held in full for three times its
/// median period (20 to 500 ms), then fades within 50 ms; five frames reopen it by a ramp (age.h).
class HeardClient {
 public:
  HeardClient();

  /// Which segment of it counts; 0: nobody gives under its name. True: another one than before,
  /// and all that was known of its frames is forgotten.
  bool follow(uint64_t generation);
  uint64_t generation() const { return generation_; }
  /// A frame may be looked at now: one each two milliseconds, however many come.
  bool is_due(int64_t t_ns) const;
  /// Begins to look at the newest frame, of the segment with that generation. False: it is not due,
  /// or was looked at before, or that segment does not count.
  bool look_at(uint64_t generation, const GivenFrame& given, int64_t t_ns);
  /// Why the frame that is looked at comes at a wrong time; kNone: it does not.
  GiverRefusal wrong_time(const GivenFrame& given, int64_t t_ns) const;
  /// Ends the look: the frame is taken with kNone, otherwise refused.
  void conclude(const GivenFrame& given, GiverRefusal why, int64_t t_ns);

  /// The weight at t_ns, dt [s] > 0 after the last, 0 to 1.
  double weigh(int64_t t_ns, double dt);
  int64_t median_period_ns() const { return age_.median_ns; }  // 0: none yet
  /// Reports what people are told of it, but for the power and what the frames hold.
  GiverState report(uint32_t client, int64_t t_ns) const;

 private:
  Age age_;
  uint64_t generation_ = 0;  // of its segment
  uint64_t last_seq_ = 0, refused_ = 0;
  uint64_t n_taken_ = 0;   // frames, of all its segments
  int64_t looked_ns_ = 0;  // at its last frame
  int64_t taken_ns_ = 0;   // GivenFrame::t_ns of the last that was taken
  int64_t came_ns_ =
      0;  // when it was: a frame is as old as the client is behind, which is no fault
  GiverRefusal refusal_ = GiverRefusal::kNone;
};

}  // namespace haptic
