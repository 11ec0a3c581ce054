// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/report/clearance.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string_view>

#include "clients/log/log_index.h"
#include "contact/query/point/closest_point.h"
#include "contact/query/proximity/mesh_distance.h"
#include "contact/shape/mesh/mesh_topology.h"
#include "proto/os/message.h"
#include "proto/wire/renderer.h"
#include "proto/wire/scene_pose.h"

namespace haptic {
namespace {

/// Where tool and objects were at one tick.
struct CarriedPose {
  int64_t t_ns = 0;
  bool is_proven = false;
  Pose X_WT;
  std::vector<Pose> X_WO;
};

/// Tool and one object, with what makes the next query faster.
struct CarriedPair {
  MeshShape object, tool;
  std::vector<Vec3> object_points, tool_points;  // one of each shell
  std::optional<TrianglePair> witness;           // nearest at the pose before
};

/// One place of the tool relative to an object.
struct Gap {
  double distance = 0;            // [m]
  Vec3 tool_point, object_point;  // in O
};

Gap gap_at(CarriedPair& pair, const Pose& X_OT) {
  const MeshDistance apart =
      mesh_distance(pair.object, pair.tool, X_OT, std::numeric_limits<double>::infinity(),
                    pair.witness ? &*pair.witness : nullptr);
  pair.witness = apart.nearest.triangles;
  const auto contains = [](const MeshShape& outer, const std::vector<Vec3>& points, const Pose& X) {
    return outer.mesh.closed && holds(outer, points, X);
  };
  const bool is_inside =
      apart.nearest.at.distance > 0 && (contains(pair.object, pair.tool_points, X_OT) ||
                                        contains(pair.tool, pair.object_points, inverse(X_OT)));
  return {is_inside ? 0 : apart.nearest.at.distance, apart.nearest.at.point_b,
          apart.nearest.at.point_a};
}

/// The poses of a tick; none where no tool with six degrees of freedom was felt.
std::optional<CarriedPose> carried_at(LogIndex& log, const ServoFrame& frame,
                                      const SessionConfig& config) {
  const auto body = [](uint32_t renderer, auto is_it) {
    return is_renderer(renderer) && is_it(static_cast<Renderer>(renderer));
  };
  CarriedPose pose;
  const auto contacts = log.contacts_at(frame);
  if (contacts != nullptr && body(contacts->renderer, is_rigid)) {
    if ((contacts->flags & kContactNoFreePose) != 0) return std::nullopt;
    pose = {contacts->answers_t_ns, true, contacts->X_WG, {}};
    for (const ObjectSeen& object : contacts->objects) pose.X_WO.push_back(object.X_WO);
  } else if (contacts != nullptr && body(contacts->renderer, is_of_body)) {
    pose.t_ns = frame.t_ns;
    pose.X_WT = frame.X_WP;
    const std::optional<SceneFrame> scene = log.scene_at(frame);
    for (uint32_t i = 0; i < config.n_objects; ++i) {
      const bool is_there = scene && i < scene->objects.size();
      pose.X_WO.push_back(is_there
                              ? object_pose_at(*scene, i, frame.t_ns, push_of(frame, kFirstHand))
                              : config.objects[i].X_WO);
    }
  } else {
    return std::nullopt;
  }
  bool usable = is_finite(pose.X_WT) && pose.X_WO.size() >= config.n_objects;
  for (uint32_t i = 0; usable && i < config.n_objects; ++i) usable = is_finite(pose.X_WO[i]);
  return usable ? std::optional(pose) : std::nullopt;
}

/// The objects that are asked for.
std::vector<uint32_t> wanted_objects(const SessionConfig& config, const std::string& name) {
  std::vector<uint32_t> wanted;
  std::vector<std::string_view> known;
  for (uint32_t i = 0; i < config.n_objects; ++i) {
    known.push_back(view(config.objects[i].name));
    if (name.empty() || known.back() == name) wanted.push_back(i);
  }
  if (!wanted.empty()) return wanted;
  if (name.empty()) throw InputError("the session has no objects; there is nothing to be clear of");
  throw InputError("the session has no object '" + shown(name) + "'; " + suggestion(name, known));
}

void add_sample(const CarriedPose& pose, uint64_t tick, double t, std::vector<CarriedPair>& pairs,
                Clearance& clearance) {
  ClearanceSample sample{tick, t, {}};
  for (size_t k = 0; k < pairs.size(); ++k) {
    Tightest& tightest = clearance.tightest[k];
    const Pose& X_WO = pose.X_WO[tightest.object];
    const Gap gap = gap_at(pairs[k], inverse(X_WO) * pose.X_WT);
    sample.distances.push_back(gap.distance);
    if (!clearance.samples.empty() && !(gap.distance < tightest.distance)) continue;
    tightest = {tightest.object,         tick,      t,   gap.distance, X_WO * gap.tool_point,
                X_WO * gap.object_point, pose.X_WT, X_WO};
  }
  clearance.proven += pose.is_proven;
  clearance.samples.push_back(std::move(sample));
}

}  // namespace

size_t Clearance::nearest() const {
  const auto least = std::ranges::min_element(tightest, {}, &Tightest::distance);
  return static_cast<size_t>(least - tightest.begin());
}

SessionConfig carried_session(const std::string& log) {
  const std::string text = McapReader(log).metadata("recording", "config");
  if (text.empty()) {
    throw InputError(shown(log) +
                     ": has no session file inside, which says what tool and objects "
                     "are; name it with --config");
  }
  return parse_config(text, log);
}

BakedSession bake_surfaces(SessionConfig config) {
  config.renderer = Renderer::kGodObject6;
  config.voxel.is_wanted = config.pieces.is_wanted = 0;
  return bake_session(config);
}

Clearance measure_clearance(const std::string& log, const SessionConfig& config,
                            const BakedSession& baked, const ClearanceOptions& options) {
  if (!baked.tool) {
    throw InputError(
        "the tool of this session is a point or a sphere; clearance is that of a "
        "[tool] with a mesh");
  }
  Clearance clearance;
  std::vector<CarriedPair> pairs;
  const MeshShape& tool = baked.tool->shape;
  for (const uint32_t i : wanted_objects(config, options.object)) {
    clearance.tightest.push_back({.object = i});
    const MeshShape& object = baked.objects[i].shape;
    pairs.push_back({object, tool, points_of_shells(object.mesh), points_of_shells(tool.mesh), {}});
  }
  LogIndex index(log);
  const uint64_t first = index.first_tick(), last = index.last_tick();
  const auto step = static_cast<uint64_t>(std::max(1.0, options.every * index.rate() + 0.5));
  int64_t before_ns = std::numeric_limits<int64_t>::min();
  for (uint64_t tick = first; tick <= last; tick += step) {
    const std::optional<ServoFrame> frame = index.frame_at(tick);
    if (!frame || (frame->flags & kServoStopped) != 0) continue;
    const auto pose = carried_at(index, *frame, config);
    // several ticks use one contact set, and of a tick that was skipped it is the frame before
    if (!pose || pose->t_ns == before_ns) continue;
    before_ns = pose->t_ns;
    const double t = 1e-9 * static_cast<double>(pose->t_ns - index.time_of(first));
    add_sample(*pose, tick, t, pairs, clearance);
    options.told(static_cast<double>(tick - first + 1) / static_cast<double>(last - first + 1));
  }
  if (clearance.samples.empty()) {
    throw InputError(shown(log) +
                     ": has no pose of a tool with six degrees of freedom; record a "
                     "session with one, such as `hapt demo frame`");
  }
  return clearance;
}

}  // namespace haptic
