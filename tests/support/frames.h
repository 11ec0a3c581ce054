// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "proto/wire/packing.h"
#include "proto/wire/scene_pose.h"
#include "proto/wire/wire.h"

namespace haptic::test {

/// An object as sim publishes one that a push does not move.
inline SceneObject scene_object(const Pose& X_WO = {}, const Twist& V_WO = {}, int64_t t_ns = 0) {
  SceneObject object{};
  object.X_WO = X_WO;
  object.V_WO = V_WO;
  object.t_ns = t_ns;
  object.extrapolation_ns = kExtrapolationNs;
  object.response = kNoResponse;
  return object;
}

/// Lets a push move an object, which has none of a hand's counters yet, of a session of one hand.
inline ObjectResponse& add_response(SceneFrame& scene, uint32_t object) {
  scene.n_hands = 1;
  scene.objects[object].response = static_cast<uint32_t>(scene.responses.size());
  scene.responses.push_back({});
  scene.seen.push_back({});
  return scene.responses.back();
}

/// The frame and all its objects are of this instant.
inline void set_time(SceneFrame& scene, int64_t t_ns) {
  scene.t_ns = t_ns;
  for (SceneObject& object : scene.objects) object.t_ns = t_ns;
}

/// Returns the bytes that a ring holds of a record with parts. The others may be anything.
template <typename T>
std::vector<std::byte> bytes_in_use(const T& record) {
  std::vector<std::byte> bytes;
  Packing<T>::for_each_run(record, [&](const std::byte* begin, size_t length) {
    bytes.insert(bytes.end(), begin, begin + length);
  });
  return bytes;
}

}  // namespace haptic::test
