// SPDX-License-Identifier: Apache-2.0
#include "clients/library/standard_messages.h"

#include <algorithm>
#include <cmath>

#include "proto/wire/scene_pose.h"

namespace haptic {

StandardMessages::StandardMessages(TraceWriter& trace, double rate) : trace_(trace) {
  if (!(rate > 0)) return;
  period_ns_ = std::llround(1e9 / rate);
  const auto add = [&](const char* topic, const ros::Type& type, const char* what) {
    return trace_.add_channel(topic, type.name, type.definition, what);
  };
  tool_ = add("/tool/pose", ros::kPoseStamped, "the tool");
  proxy_ = add("/proxy/pose", ros::kPoseStamped, "this tick's proxy");
  wrench_ = add("/device/wrench", ros::kWrenchStamped, "what the device exerts on the hand");
  tf_ = add("/tf", ros::kTfMessage, "tool, proxy, objects and base");
}

void StandardMessages::add(const ServoFrame& frame, const SceneFrame* scene) {
  if (period_ns_ == 0) return;
  if (frame.t_ns < next_ns_) return;
  // on a grid, unless ticks are missing for longer than a period
  const bool is_on_time = frame.t_ns < next_ns_ + period_ns_;
  next_ns_ = (is_on_time ? next_ns_ : frame.t_ns) + period_ns_;
  const Stamp stamp{frame.t_ns, frame.realtime_ns, sequence_++};
  const int64_t t = frame.realtime_ns;
  trace_.write_message(tool_, ros::pose_stamped(t, "world", frame.X_WT), stamp);
  trace_.write_message(proxy_, ros::pose_stamped(t, "world", frame.X_WP), stamp);
  trace_.write_message(wrench_, ros::wrench_stamped(t, "base", frame.F_device_B), stamp);
  transforms_.clear();
  transforms_.push_back({"world", "tool", frame.X_WT});
  transforms_.push_back({"world", "proxy", frame.X_WP});
  if (X_WB_) transforms_.push_back({"world", "base", *X_WB_});
  const size_t objects = scene == nullptr ? 0 : scene->objects.size();
  for (uint32_t i = 0; i < objects; ++i) {
    transforms_.push_back({"world", "object_" + std::to_string(i),
                           object_pose_at(*scene, i, frame.t_ns, push_of(frame, kFirstHand))});
  }
  trace_.write_message(tf_, ros::tf_message(t, transforms_), stamp);
}

void StandardMessages::add_mesh(const ros::MeshMarker& mesh, const Stamp& stamp) {
  if (period_ns_ == 0) return;
  auto channel = markers_.find(mesh.frame);
  if (channel == markers_.end()) {
    const std::string topic = "/scene/markers/" + mesh.frame;
    const uint16_t id =
        trace_.add_channel(topic, ros::kMarker.name, ros::kMarker.definition, "how it is drawn");
    channel = markers_.emplace(mesh.frame, id).first;
  }
  trace_.write_message(channel->second, ros::triangle_list(stamp.realtime_ns, mesh), stamp);
}

}  // namespace haptic
