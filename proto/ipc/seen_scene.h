// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "proto/ipc/attachments.h"
#include "proto/ipc/channels.h"
#include "proto/wire/packing.h"
#include "proto/wire/scene_pose.h"

namespace haptic {

/// The newest scene as a hand sees it: where the other hands have brought the objects since sim
/// used their counters. Servo and contact of a hand both read it, in each of their steps.
class SeenScene {
 public:
  /// From a Child or from Attachments, before either is started.
  template <typename Rings>
  SeenScene(Rings& rings, uint32_t hand, uint32_t n_hands)
      : scenes_(rings.template ring<&SimChannels::frames>(Start::kOldest)) {
    for (uint32_t other = 0; other < n_hands; ++other) {
      if (other == hand) continue;
      others_.push_back(
          {other, rings.template ring<&ServoChannels::frames>(Start::kNewest, other)});
    }
  }

  /// Null: none has come. It is valid until the next call.
  const SceneFrame* latest() noexcept {
    any_ |= scenes_.latest(newest_);
    for (Other& other : others_) other.any |= other.frames.latest(other.frame);
    if (!any_) return nullptr;
    if (others_.empty()) return &newest_;
    copy_in_use(newest_, seen_);
    for (const Other& other : others_) {
      if (other.any) add_pushes_of_other(seen_, push_of(other.frame, other.hand));
    }
    return &seen_;
  }
  /// True once a scene has come.
  bool any() const noexcept { return any_; }
  /// A few microseconds before latest(): starts to fetch what another core has written.
  void prefetch() const noexcept { scenes_.prefetch_newest(); }

 private:
  struct Other {
    uint32_t hand;
    RingSource<&ServoChannels::frames> frames;
    ServoFrame frame{};
    bool any = false;
  };
  RingSource<&SimChannels::frames> scenes_;
  std::vector<Other> others_;
  SceneFrame newest_{}, seen_{};
  bool any_ = false;
};

}  // namespace haptic
