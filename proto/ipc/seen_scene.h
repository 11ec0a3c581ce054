// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "proto/ipc/attachments.h"
#include "proto/ipc/channels.h"
#include "proto/wire/other_tools.h"
#include "proto/wire/packing.h"
#include "proto/wire/scene_pose.h"

namespace haptic {

/// The newest scene as a hand sees it: the objects where the other hands have brought them since
/// sim used their counters, and behind them the tools of those hands (with_tools). Servo and
/// contact of a hand both read it, in each of their steps.
///
/// A tool is where its own hand is, not its proxy, and gives way by the spring of its coupling: two
/// tools that meet are two springs in series, and each side computes the same force from the same
/// two hands.
class SeenScene {
 public:
  /// From a Child or from Attachments, before either is started.
  template <typename Rings>
  SeenScene(Rings& rings, uint32_t hand, uint32_t n_hands, bool has_tools)
      : scenes_(rings.template ring<&SimChannels::frames>(Start::kOldest)), has_tools_(has_tools) {
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
      see_other_hand(seen_, other.hand, other.newest(), has_tools_);
    }
    return &seen_;
  }
  /// Stiffness of the coupling of each tool, in the order of the objects; 0: the hand feels
  /// nothing, and its tool gives way [N/m].
  ToolStiffnesses stiffnesses(int64_t t_ns) const noexcept {
    ToolStiffnesses out;
    for (const Other& other : others_) {
      if (has_tools_) out.push_back(stiffness_of_tool(other.newest(), t_ns));
    }
    return out;
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

    const ServoFrame* newest() const { return any ? &frame : nullptr; }
  };
  RingSource<&SimChannels::frames> scenes_;
  std::vector<Other> others_;
  bool has_tools_;
  SceneFrame newest_{}, seen_{};
  bool any_ = false;
};

}  // namespace haptic
