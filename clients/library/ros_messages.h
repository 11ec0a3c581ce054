// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "proto/math/pose.h"

/// Messages of ROS 2 that viewers of robots know, in CDR (little endian) as MCAP files hold them.
/// Frames: "world", "base" (of the device), "tool", "proxy", "object_0" and so on.
namespace haptic::ros {

/// A message type: its name, and its definition with all nested types, for MCAP's `ros2msg`.
struct Type {
  std::string_view name, definition;
};
extern const Type kPoseStamped, kWrenchStamped, kTfMessage, kMarker;

using Message = std::vector<std::byte>;

/// A pose in a frame, at an instant [ns since 1970].
Message pose_stamped(int64_t realtime_ns, std::string_view frame, const Pose& pose);
/// A wrench expressed in a frame, about its origin.
Message wrench_stamped(int64_t realtime_ns, std::string_view frame, const Wrench& wrench);

/// The pose of a frame in its parent.
struct Transform {
  std::string parent, child;
  Pose X;
};
Message tf_message(int64_t realtime_ns, std::span<const Transform> transforms);

/// The triangles of a mesh in a frame, to be shown until another of the same name and number
/// replaces them. Vertices are of that frame [m]; triangles name them, counter-clockwise.
struct MeshMarker {
  std::string frame, name;
  int32_t number = 0;
  std::array<float, 4> colour{0.7f, 0.7f, 0.7f, 1};  // r, g, b, a
  std::span<const Vec3> vertices;
  std::span<const std::array<uint32_t, 3>> triangles;
};
Message triangle_list(int64_t realtime_ns, const MeshMarker& marker);

}  // namespace haptic::ros
