// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "proto/wire/wire.h"

namespace haptic {

/// What a hand has pushed the objects of clients with, frame by frame of its servo, for as long as
/// a client may be behind: four seconds at 1 kHz.
class PushHistory {
 public:
  static constexpr size_t kMost = 4096;  // frames

  /// Of `n_objects`, whose responses follow each other from `first_response` on. All memory is
  /// allocated here.
  PushHistory(size_t n_objects, size_t first_response);

  /// The next frame. A servo that has begun anew begins anew here; a frame that is not finite is
  /// left out.
  void add(const ServoFrame& frame);

  /// The number of the frame of this tick; empty: it has not been, or is forgotten.
  std::optional<uint64_t> find(uint64_t tick) const;

  /// Frames are numbered on; begin() to end() − 1 are remembered.
  uint64_t begin() const { return end_ - size_; }
  uint64_t end() const { return end_; }
  int64_t t_ns(uint64_t n) const { return frames_[n % kMost].t_ns; }
  /// The counters of an object, 0 to n_objects − 1, in that frame.
  const ObjectPush& push(uint64_t n, size_t object) const {
    return pushes_[n % kMost * n_objects_ + object];
  }

 private:
  struct Frame {
    uint64_t tick = 0;
    int64_t t_ns = 0;
  };
  size_t n_objects_, first_response_;
  std::vector<Frame> frames_;
  std::vector<ObjectPush> pushes_;  // of each frame, those of its objects
  uint64_t end_ = 0, size_ = 0;
  int64_t since_ns_ = 0;  // where the counters began
};

}  // namespace haptic
