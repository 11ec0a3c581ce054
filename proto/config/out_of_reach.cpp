// SPDX-License-Identifier: Apache-2.0
#include "proto/config/out_of_reach.h"

#include <algorithm>

#include "proto/config/quantity.h"
#include "proto/wire/scene_pose.h"

namespace haptic {

OutOfReach out_of_reach(const SessionConfig& config, const SceneFrame& scene) {
  OutOfReach gone{0, config.sim_reach};
  const size_t n = std::min<size_t>(config.n_objects, scene.objects.size());
  for (uint32_t i = 0; i < n; ++i) {
    const ObjectConfig& object = config.objects[i];
    gone.bodies += has_mass(object.body) &&
                   is_out_of_reach(scene.objects[i].X_WO, object.X_WO, config.sim_reach);
  }
  return gone;
}

std::string out_of_reach_text(const OutOfReach& gone) {
  if (gone.bodies == 0) return "";
  return std::to_string(gone.bodies) + (gone.bodies == 1 ? " body" : " bodies") +
         " out of reach (" + quantity_text(gone.reach, Dimension::kLength) + ")";
}

std::string out_of_reach_line(const OutOfReach& gone) {
  const std::string text = out_of_reach_text(gone);
  return text.empty() ? "" : text + ": " + kMendOutOfReach;
}

}  // namespace haptic
