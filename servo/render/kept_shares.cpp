// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/render/kept_shares.h"

#include <algorithm>

#include "proto/math/assert.h"

namespace haptic {

void keep(const KeptShares& shares, const TickScene& scene, Rendered& rendered) {
  HAPTIC_ASSERT(shares.size() == rendered.push_W.size());
  const bool is_any = std::ranges::any_of(shares, [](double share) { return share < 1; });
  Wrench pushed_W, kept_W;
  double size = 0, left = 0;
  for (size_t i = 0; i < shares.size() && is_any; ++i) {
    Wrench& push_W = rendered.push_W[i];
    if (push_W == Wrench{} || !is_finite(push_W)) continue;
    pushed_W = pushed_W + push_W;
    size += norm(push_W.f);
    left += shares[i] * norm(push_W.f);
    push_W = shares[i] * push_W;
    kept_W = kept_W + push_W;
  }
  const double rest = size > 0 ? left / size : 1;
  if (is_any && pushed_W != Wrench{}) rendered.F_W = kept_W + rest * (rendered.F_W + -pushed_W);
  for (size_t s = 0; s < scene.surfaces.size(); ++s) {
    const uint32_t object = scene.surfaces[s].object;
    if (object >= scene.n_objects()) continue;
    Wrench& of_surface_W = rendered.push_W[scene.n_objects() + s];
    rendered.push_W[object] = rendered.push_W[object] + of_surface_W;
    of_surface_W = {};
  }
}

}  // namespace haptic
