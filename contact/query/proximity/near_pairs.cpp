// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/proximity/near_pairs.h"

#include <cmath>

#include "contact/query/box/box_distance.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

/// Calls on_near for each near pair until it returns false; false: it did.
template <class OnNear>
bool descend(const MeshShape& shape_A, const MeshShape& shape_B, const Pose& X_AB, double band,
             OnNear&& on_near) {
  const ObbTree &tree_A = shape_A.tree, &tree_B = shape_B.tree;
  const bool is_band = std::isfinite(band) && band >= 0;
  if (tree_A.nodes.empty() || tree_B.nodes.empty() || !is_finite(X_AB) || !is_band) return true;
  const BoxDistance boxes(X_AB);
  PairBatch batch(shape_A, shape_B, X_AB);
  const auto measure_waiting = [&] {
    return batch.measure_each([&](double distance_squared, const auto& near) {
      return distance_squared > band * band || on_near(near);
    });
  };
  const auto may_be_near = [&](const CompactObb& a, const CompactObb& b) {
    return !(boxes.at_least(a, b) > band);
  };
  const auto wait = [&](const ObbNode& a, const ObbNode& b) {
    batch.add_leaves(a, b);
    return batch.has_room_for_leaves() || measure_waiting();
  };
  return descend_both(tree_A, tree_B, may_be_near, wait) && measure_waiting();
}

}  // namespace

size_t near_pairs(const MeshShape& shape_A, const MeshShape& shape_B, const Pose& X_AB, double band,
                  std::span<NearPair> out) {
  size_t found = 0;
  descend(shape_A, shape_B, X_AB, band, [&](const auto& near) {
    if (found < out.size()) out[found] = near();
    ++found;
    return true;
  });
  return found;
}

bool any_near_pair(const MeshShape& shape_A, const MeshShape& shape_B, const Pose& X_AB,
                   double band) {
  return !descend(shape_A, shape_B, X_AB, band, [](const auto&) { return false; });
}

}  // namespace haptic
