// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "clients/library/ros_messages.h"
#include "clients/log/trace_writer.h"
#include "proto/log/trace.h"
#include "proto/wire/wire.h"

namespace haptic {

/// Writes what viewers of robots know into a recording, beside its own topics, at a lower rate:
///
///   /tool/pose, /proxy/pose   geometry_msgs/msg/PoseStamped, in "world"
///   /device/wrench            geometry_msgs/msg/WrenchStamped, in "base": of the device on the
///                             hand, about the handle
///   /tf                       tf2_msgs/msg/TFMessage: tool, proxy, objects and base in "world"
///   /scene/markers/tool,      visualization_msgs/msg/Marker, where meshes are given. Each has its
///   /scene/markers/object_0 … topic, once: where a viewer goes to in a file it asks for the last
///                             message of each topic
///
/// Their time is that of the servo frame they are made of (ServoFrame::realtime_ns).
class StandardMessages {
 public:
  /// `rate` [Hz]; 0: none, the file does not get the topics. The trace must outlive it.
  StandardMessages(TraceWriter& trace, double rate);

  /// A servo frame, with the newest scene or null; writes if one is due.
  void add(const ServoFrame& frame, const SceneFrame* scene);
  /// The pose X_WB of the device's base; without it /tf has no "base".
  void set_base(const Pose& X_WB) { X_WB_ = X_WB; }
  /// A mesh, when it comes or has changed; its topic is named after its frame.
  void add_mesh(const ros::MeshMarker& mesh, const Stamp& stamp);

 private:
  TraceWriter& trace_;
  int64_t period_ns_ = 0;  // 0: none
  int64_t next_ns_ = 0;
  uint64_t sequence_ = 0;
  uint16_t tool_ = 0, proxy_ = 0, wrench_ = 0, tf_ = 0;
  std::map<std::string, uint16_t> markers_;  // channel by frame
  std::optional<Pose> X_WB_;
  std::vector<ros::Transform> transforms_;
};

}  // namespace haptic
