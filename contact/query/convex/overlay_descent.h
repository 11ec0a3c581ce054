// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>

#include "contact/query/convex/gauss_overlay.h"

namespace haptic {

/// A search for the shallowest overlay vertex near a start: always on from the shallowest vertex
/// that was not expanded yet, with all its neighbours beyond which a shallower one may be. A
/// support that is shallower than `best` at an angle of at most α is, on the way there, no more
/// than h(θ) = d cos θ + e sin θ above 0, with d the depth here and e the extent of the facet that
/// way; so a neighbour needs a look only if h(α) < best. With a facet that extends far around the
/// foot of its plane there is none, and the search ends at once.
class OverlayDescent {
 public:
  explicit OverlayDescent(const GaussOverlay& overlay);

  /// False where the room was not enough; the best so far is the best.
  bool run(const OverlayVertex& start);
  const OverlayVertex& best() const { return visited_[best_]; }
  int n_steps() const { return n_steps_; }  // marching steps: expansions that found a better one

 private:
  static constexpr size_t kMaxVisited = 64;

  size_t shallowest() const;
  bool expand(size_t at);
  bool add(const OverlayVertex& v);

  const GaussOverlay& overlay_;
  const double cos_, sin_;  // of α, at most 0.8 rad and less between hulls of many vertices
  union {
    std::array<OverlayVertex, kMaxVisited> visited_;  // not initialised: most queries need few
  };
  std::array<bool, kMaxVisited> expanded_;
  size_t n_ = 0, best_ = 0;
  int n_steps_ = 0;
};

}  // namespace haptic
