// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/report/summary.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <ranges>
#include <utility>

#include "clients/report/rigid_pose.h"
#include "contact/bake/inside.h"
#include "contact/query/point/closest_point.h"
#include "proto/config/out_of_reach.h"
#include "proto/log/trace.h"
#include "proto/math/motion_metric.h"
#include "proto/os/progress.h"
#include "proto/wire/renderer.h"
#include "proto/wire/scene_pose.h"

namespace haptic {
namespace {

constexpr const char* kExactCheck = "checking each pose exactly";
constexpr double kTouchForce = 0.05;        // [N]; weaker forces count as free space
constexpr size_t kMostPosesChecked = 2000;  // poses of a rigid tool; each check takes about 1 ms
constexpr size_t kMostWaysChecked = 100;    // each takes up to 32 exact tests per object
constexpr int kPlacesOfWay = 32;            // samples along the straight path to a re-placed tool
constexpr double kFarShare = 0.5;  // of the tool's size; no valid path is longer within one answer

template <typename Items, typename Get>
Histogram durations(const Items& items, Get get) {
  Histogram histogram;
  for (const auto& item : items) histogram.add(get(item));
  return histogram;
}

/// Depth of the deepest of these points, given in the frame of the proxy, inside any object [m].
double proxy_depth(const ServoFrame& frame, const std::optional<SceneFrame>& scene,
                   const SessionConfig& config, std::span<const BakedShape> shapes,
                   std::span<const Vec3> points_P) {
  double deepest = 0;
  for (uint32_t i = 0; i < shapes.size(); ++i) {
    if (!shapes[i].shape.mesh.closed) continue;
    const bool is_there = scene && i < scene->objects.size();
    const Pose X_WO = is_there ? object_pose_at(*scene, i, frame.t_ns, push_of(frame, kFirstHand))
                               : config.objects[i].X_WO;
    const Pose X_OP = inverse(X_WO) * frame.X_WP;
    for (const Vec3& p_P : points_P) {
      const ClosestPoint c =
          closest_point(shapes[i].shape, X_OP * p_P, std::numeric_limits<double>::infinity());
      if (c.found && c.inside) deepest = std::max(deepest, c.distance);
    }
  }
  return deepest;
}

/// About `most` items of the list, evenly spaced.
template <typename Items>
auto some_of(const Items& items, size_t most) {
  std::vector<typename Items::value_type> some;
  const size_t every = std::max<size_t>(items.size() / most, 1);
  for (size_t i = 0; i < items.size(); i += every) some.push_back(items[i]);
  return some;
}

/// True if the tool would be inside an object anywhere on its way from one pose to another, both
/// relative to that object.
bool is_through(const RigidPoseJudge& judge, const Pose& from_OT, const Pose& to_OT) {
  const Twist way = way_between(from_OT, to_OT);
  for (int k = 1; k < kPlacesOfWay; ++k) {
    if (judge.is_entered(moved(from_OT, static_cast<double>(k) / kPlacesOfWay * way))) return true;
  }
  return false;
}

/// True if the servo rendered no force at this time, whatever the contacts.
bool is_closed(const PackedRecords<ServoFrame>& frames, int64_t t_ns) {
  const std::optional<ServoFrame> frame = frames.find(&ServoFrame::t_ns, t_ns);
  return frame && (frame->flags & kServoClosed) != 0;
}

/// Counts poses of a rigid tool that were not reached along a path: contact flags them as
/// re-placed, or they are too far from the previous one. While the servo is closed the hand may
/// pass through objects, so the next pose is not compared.
void check_places(const std::vector<VerifiedProxy>& rigid, const PackedRecords<ServoFrame>& frames,
                  std::span<const RigidPoseJudge> judges, double size, Penetration& out) {
  const VerifiedProxy* last = nullptr;
  for (const VerifiedProxy& proxy : rigid) {
    const bool is_unknown = (proxy.flags & kContactNoFreePose) != 0;
    out.without_pose += is_unknown;
    if (is_closed(frames, proxy.answers_t_ns)) last = nullptr;
    if (is_unknown || proxy.X_WO.size() < judges.size()) continue;
    const VerifiedProxy* before = std::exchange(last, &proxy);
    if (before == nullptr) continue;
    bool is_anew = (proxy.flags & kContactReseeded) != 0, is_across = false;
    for (size_t i = 0; i < judges.size(); ++i) {
      const Pose from = inverse(before->X_WO[i]) * before->X_WG;
      const Pose to = inverse(proxy.X_WO[i]) * proxy.X_WG;
      const bool is_far = norm(to.p - from.p) > kFarShare * size;
      if (!(is_anew || is_far) || out.placed_anew >= kMostWaysChecked) continue;
      is_anew = true;
      is_across |= is_through(judges[i], from, to);
    }
    out.placed_anew += is_anew;
    out.across += is_across;
  }
}

/// Checks a sample of the verified poses of a rigid tool for intersection with any object. The
/// renderer is read from each set, because a session can change it.
void check_verified(const SessionData& data, const BakedSession& baked, Penetration& out) {
  std::vector<VerifiedProxy> rigid;
  for (const VerifiedProxy& proxy : data.proxies) {
    if (!is_renderer(proxy.renderer)) continue;  // of a recording, which may hold anything
    if (is_rigid(static_cast<Renderer>(proxy.renderer))) rigid.push_back(proxy);
  }
  if (rigid.empty()) {
    out.unchecked = "not asked: a soft proxy may be inside";
    return;
  }
  std::vector<RigidPoseJudge> judges;
  for (const BakedShape& object : baked.objects) {
    judges.emplace_back(object.shape, baked.tool->shape);
  }
  const std::vector<VerifiedProxy> asked = some_of(rigid, kMostPosesChecked);
  Progress progress(kExactCheck, static_cast<double>(asked.size()));
  for (const VerifiedProxy& proxy : asked) {
    progress.step();
    if ((proxy.flags & kContactNoFreePose) != 0 || proxy.X_WO.size() < judges.size()) continue;
    ++out.verified_checked;
    bool is_inside = false;
    for (size_t i = 0; i < judges.size(); ++i) {
      is_inside |= judges[i].is_entered(inverse(proxy.X_WO[i]) * proxy.X_WG);
    }
    out.verified_inside += is_inside;
  }
  const TriangleMesh& tool = baked.tool->shape.mesh;
  check_places(rigid, data.frames, judges, norm(tool.upper - tool.lower), out);
}

/// For a tool with six degrees of freedom.
Penetration measure_body(const SessionData& data, const SessionConfig& config,
                         const BakedSession& baked) {
  Penetration out;
  check_verified(data, baked, out);
  std::vector<size_t> touching;
  for (size_t k = 0; k < data.frames.size(); ++k) {
    if ((data.frames[k].flags & kServoContact) != 0) touching.push_back(k);
  }
  const std::vector<Vec3> points_T =
      some_of(std::vector<Vec3>(baked.tool->shape.mesh.vertices.begin(),
                                baked.tool->shape.mesh.vertices.end()),
              1000);
  for (const size_t k : some_of(touching, 200)) {
    const ServoFrame frame = data.frames[k];
    const double depth = proxy_depth(frame, data.scenes.find(&SceneFrame::seq, frame.scene_seq),
                                     config, baked.objects, points_T);
    out.deepest_proxy = std::max(out.deepest_proxy, depth);
  }
  return out;
}

}  // namespace

bool is_touching(const ServoFrame& frame) {
  return (frame.flags & kServoContact) != 0 && norm(frame.F_device_B.f) > kTouchForce;
}

VerifiedProxy verified_proxy(const ContactSet& set) {
  VerifiedProxy proxy{set.answers_t_ns, set.X_WG, {}, set.busy_ns, set.flags, set.renderer};
  for (const ObjectSeen& object : set.objects) proxy.X_WO.push_back(object.X_WO);
  return proxy;
}

SessionData load_session(const std::string& log) {
  SessionData data;
  const TraceReader reader(log);
  // the closing frame of a servo is not a tick
  reader.for_each<ServoFrame>(servo_topic(kFirstHand), [&](const ServoFrame& frame, const Stamp&) {
    ++data.recorded;
    if ((frame.flags & kServoStopped) == 0) data.frames.push_back(frame);
  });
  reader.for_each<SceneFrame>(
      kSimTopic, [&](const SceneFrame& scene, const Stamp&) { data.scenes.push_back(scene); });
  reader.for_each<ContactSet>(contact_topic(kFirstHand), [&](const ContactSet& set, const Stamp&) {
    ++data.recorded;
    data.proxies.push_back(verified_proxy(set));
  });
  data.recorded += data.scenes.size();
  return data;
}

PortEnergy port_energy(const PackedRecords<ServoFrame>& frames) {
  PortEnergy energy;
  std::optional<ServoFrame> before;
  for (const ServoFrame& frame : frames) {
    if (before) {
      const Vec3 step_B = frame.device.X_BH.p - before->device.X_BH.p;
      const Quat turn = frame.device.X_BH.q * conjugate(before->device.X_BH.q);
      const double work =
          dot(before->F_device_B.f, step_B) + dot(before->F_device_B.t, to_rotation_vector(turn));
      (work < 0 ? energy.into_device : energy.returned) += std::fabs(work);
    }
    before = frame;
  }
  return energy;
}

Penetration measure_penetration(const SessionData& data, const SessionConfig& config,
                                const BakedSession& baked) {
  if (is_of_body(config.renderer) && baked.tool) return measure_body(data, config, baked);
  const std::span<const BakedShape> shapes = baked.objects;
  Penetration out;
  std::vector<std::unique_ptr<InsideOracle>> oracles;
  for (const BakedShape& object : shapes) {
    oracles.push_back(object.shape.mesh.closed ? std::make_unique<InsideOracle>(object.shape.mesh)
                                               : nullptr);
  }
  // an open surface has no inside
  const bool any_closed = std::any_of(shapes.begin(), shapes.end(), [](const BakedShape& object) {
    return object.shape.mesh.closed;
  });
  if (!any_closed && !shapes.empty()) out.unchecked = "not checked: an open mesh has no inside";
  Progress progress(kExactCheck, static_cast<double>(data.proxies.size()));
  for (const VerifiedProxy& proxy : data.proxies) {
    progress.step();
    if ((proxy.flags & kContactNoFreePose) != 0 || !any_closed) continue;
    if (proxy.X_WO.size() < oracles.size()) continue;
    ++out.verified_checked;
    for (size_t i = 0; i < oracles.size(); ++i) {
      const Vec3 g_O = inverse(proxy.X_WO[i]) * proxy.X_WG.p;
      if (oracles[i] != nullptr && oracles[i]->inside(g_O)) ++out.verified_inside;
    }
  }
  for (const ServoFrame& frame : data.frames) {
    if ((frame.flags & kServoContact) == 0) continue;
    const double depth = proxy_depth(frame, data.scenes.find(&SceneFrame::seq, frame.scene_seq),
                                     config, shapes, std::array{Vec3{}});
    out.deepest_proxy = std::max(out.deepest_proxy, depth);
  }
  return out;
}

namespace {

/// Rows on the depth of the proxies, and on whether the verified one has changed sides.
void add_penetration(const Penetration& penetration, Renderer renderer, Rows& rows) {
  rows.add("deepest penetration of this tick's proxy", penetration.deepest_proxy, "m");
  if (penetration.unchecked.empty()) {
    rows.add("verified proxy inside (exact check)",
             static_cast<double>(penetration.verified_inside), "",
             given(0, penetration.verified_inside == 0 && penetration.verified_checked > 0));
  } else {
    rows.note("verified proxy inside (exact check)", penetration.unchecked);
  }
  if (is_rigid(renderer)) {
    rows.add({{"answers without a free pose: nothing felt", penetration.without_pose},
              {"verified proxy placed anew", penetration.placed_anew},
              {"of these with an object between: changes of side", penetration.across, "",
               kMustBeZero}});
  }
}

/// Adds the share of the ticks in which a process fell behind, where any did.
void add_behind(const PackedRecords<ServoFrame>& frames, Rows& rows) {
  for (const BehindRow& row : kBehind) {
    const auto ticks = std::ranges::count_if(
        frames, [&](const ServoFrame& f) { return (f.flags & row.flag) != 0; });
    if (ticks == 0) continue;
    const double share = 100 * static_cast<double>(ticks) / static_cast<double>(frames.size());
    rows.add(std::string(row.metric), share, "%");
  }
}

}  // namespace

std::vector<Row> summarize(const std::string& name, const SessionData& data,
                           const SessionConfig& config, const Penetration& penetration) {
  Rows rows(name);
  const auto& frames = data.frames;
  const auto ticks = static_cast<double>(frames.size());
  const double limit = std::min(config.safety.max_force, config.device.max_force);
  const double torque_limit = std::min(config.safety.max_torque, config.device.max_torque);
  double peak = 0, peak_torque = 0, felt_torque = 0, deepest = 0;
  size_t touching = 0, faults = 0, lost_time = 0;
  const int64_t begin_ns = frames.empty() ? 0 : frames.front().t_ns;
  int64_t first_touch_ns = 0;
  for (const ServoFrame& f : frames) {
    const double force = norm(f.F_device_B.f);
    peak = std::max(peak, force);
    peak_torque = std::max(peak_torque, norm(f.F_coupling_W.t));
    felt_torque = std::max(felt_torque, norm(f.F_device_B.t));
    if (is_touching(f) && ++touching == 1) first_touch_ns = f.t_ns - begin_ns;
    faults += (f.flags & kServoFault) != 0;
    lost_time += (f.device.flags & kDeviceLostTime) != 0;
    deepest = std::max(deepest, f.depth);
  }
  const uint64_t skipped = frames.empty() ? 0 : frames.back().skipped - frames.front().skipped;
  rows.add("ticks", ticks);
  add_behind(frames, rows);
  rows.add("late ticks (grid points skipped)", skipped);
  rows.add("wake lateness", durations(frames, [](const auto& f) { return f.wake_late_ns; }));
  rows.add("servo busy", durations(frames, [](const auto& f) { return f.busy_ns; }));
  rows.add("contact busy", durations(data.proxies, [](const auto& p) { return p.busy_ns; }));
  if (data.proxies.size() > 1) {
    const auto span =
        static_cast<double>(data.proxies.back().answers_t_ns - data.proxies.front().answers_t_ns);
    rows.add("contact rate", static_cast<double>(data.proxies.size() - 1) / (span * 1e-9), "Hz");
  }
  if (!data.scenes.empty()) {
    const std::string gone = out_of_reach_line(out_of_reach(config, data.scenes.back()));
    if (!gone.empty()) rows.note(std::string(kGone), gone);
  }
  rows.add("ticks in contact", touching, "", at_least(1));
  if (touching > 0) {
    rows.add({{std::string(kContactShare), 100 * static_cast<double>(touching) / ticks, "%"},
              {std::string(kFirstTouch), 1e-9 * static_cast<double>(first_touch_ns), "s"}});
  }
  rows.add("peak force at the device", peak, "N", at_most(limit));
  if (is_of_body(config.renderer)) {
    rows.add({{"peak torque on the tool", peak_torque, "N·m"},
              {"peak torque at the device", felt_torque, "N·m", at_most(torque_limit)},
              {"largest distance from the hand to its proxy", deepest, "m"}});
  } else {
    rows.add("deepest push of the hand behind the surface", deepest, "m");
  }
  add_penetration(penetration, config.renderer, rows);
  const PortEnergy energy = port_energy(frames);
  rows.add({{"energy from hand", energy.into_device, "J"},
            {"energy to hand", energy.returned, "J"},
            {"energy balance of the hand (positive: passive)", energy.net(), "J"}});
  if (lost_time > 0) rows.add("stalls longer than the simulated hand can catch up with", lost_time);
  rows.add({{"ticks in fault", faults, "", kMustBeZero},
            {"samples recorded", data.recorded},
            {"samples lost", data.lost, "", kMustBeZero}});
  return rows.rows();
}

}  // namespace haptic
