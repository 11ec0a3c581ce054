// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "proto/wire/wire.h"

namespace haptic {

/// Changes that people have asked for and that the servos have not yet taken: each is answered when
/// all its hands have echoed their revision, or after a second.
class Echoes {
 public:
  struct Revision {
    uint32_t hand;
    uint64_t number;
  };
  struct Change {
    uint64_t peer;  // who waits for the answer
    std::vector<Revision> revisions;
    bool clears_fault;
    std::string warning;  // to answer with; empty: nothing
  };
  /// The newest frame of a hand's servo.
  using FrameOf = std::function<const ServoFrame&(uint32_t hand)>;
  using Answer = std::function<void(uint64_t peer, const std::string& text)>;

  void await(Change change, int64_t t_ns);
  bool any() const { return !waiting_.empty(); }
  void answer(int64_t t_ns, const FrameOf& frame_of, const Answer& say);

 private:
  struct Waiting {
    Change change;
    int64_t give_up_ns;
  };
  std::vector<Waiting> waiting_;
};

}  // namespace haptic
