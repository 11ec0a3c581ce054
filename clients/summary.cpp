// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/summary.h"

#include <algorithm>
#include <limits>
#include <memory>

#include "contact/bake_inside.h"
#include "contact/query/closest_point.h"
#include "proto/scene_pose.h"
#include "proto/trace.h"

namespace haptic {
namespace {

constexpr double kTouchForce = 0.05;  // below, a hand feels free space [N]

struct Quantiles {
  double p50 = 0, p99 = 0, max = 0;
};

Quantiles quantiles(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto at = [&](double q) {
    const auto i = static_cast<size_t>(q * static_cast<double>(values.size()));
    return values[std::min(values.size() - 1, i)];
  };
  return {at(0.5), at(0.99), values.back()};
}

template <typename Items, typename Get>
Quantiles quantiles_of(const Items& items, Get get) {
  std::vector<double> values;
  values.reserve(items.size());
  for (const auto& item : items) values.push_back(static_cast<double>(get(item)) * 1e-9);
  return quantiles(std::move(values));
}

/// The scene in force at a frame; frames before the first scene see the configured poses.
const SceneFrame* scene_of(const std::vector<SceneFrame>& scenes, uint64_t seq) {
  const auto it =
      std::lower_bound(scenes.begin(), scenes.end(), seq,
                       [](const SceneFrame& s, uint64_t wanted) { return s.seq < wanted; });
  return it != scenes.end() && it->seq == seq ? &*it : nullptr;
}

double proxy_depth(const ServoFrame& frame, const SceneFrame* scene, const SessionConfig& config,
                   std::span<const BakedShape> shapes) {
  double deepest = 0;
  for (uint32_t i = 0; i < shapes.size(); ++i) {
    if (!shapes[i].shape.mesh.closed) continue;
    const Pose X_WO =
        scene != nullptr ? object_pose_at(*scene, i, frame.t_ns) : config.objects[i].X_WO;
    const ClosestPoint c = closest_point(shapes[i].shape, inverse(X_WO) * frame.X_WP.p,
                                         std::numeric_limits<double>::infinity());
    if (c.found && c.inside) deepest = std::max(deepest, c.distance);
  }
  return deepest;
}

class Rows {
 public:
  explicit Rows(std::string case_name) : case_name_(std::move(case_name)) {}

  void add(const std::string& metric, double value, const std::string& unit) {
    rows_.push_back({case_name_, metric, value, unit, "", {}, {}, {}});
  }
  void add(const std::string& metric, double value, const std::string& unit, double goal,
           bool holds) {
    rows_.push_back({case_name_, metric, value, unit, "", {}, goal, holds});
  }
  void add(const std::string& metric, const Quantiles& q) {
    add(metric + " p50", q.p50, "s");
    add(metric + " p99", q.p99, "s");
    add(metric + " max", q.max, "s");
  }
  std::vector<Row> take() { return std::move(rows_); }

 private:
  std::string case_name_;
  std::vector<Row> rows_;
};

}  // namespace

VerifiedProxy verified_proxy(const ContactSet& set) {
  return {set.answers_t_ns, set.X_WG, set.X_WO, set.busy_ns, set.flags};
}

SessionData load_session(const std::string& log) {
  SessionData data;
  const TraceReader reader(log);
  // the closing frame of a servo is no tick
  reader.for_each<ServoFrame>(kServo0Topic, [&](const ServoFrame& frame, const Stamp&) {
    if ((frame.flags & kServoStopped) == 0) data.frames.push_back(frame);
  });
  data.scenes = reader.read(kSimTopic);
  reader.for_each<ContactSet>(kContact0Topic, [&](const ContactSet& set, const Stamp&) {
    data.proxies.push_back(verified_proxy(set));
  });
  return data;
}

PortEnergy port_energy(std::span<const ServoFrame> frames) {
  PortEnergy energy;
  for (size_t k = 0; k + 1 < frames.size(); ++k) {
    const Vec3 step_B = frames[k + 1].device.X_BH.p - frames[k].device.X_BH.p;
    const double work = dot(frames[k].F_device_B.f, step_B);
    (work < 0 ? energy.into_device : energy.returned) += std::fabs(work);
  }
  return energy;
}

Penetration measure_penetration(const SessionData& data, const SessionConfig& config,
                                std::span<const BakedShape> shapes) {
  Penetration out;
  std::vector<std::unique_ptr<InsideOracle>> oracles;
  for (const BakedShape& baked : shapes) {
    oracles.push_back(baked.shape.mesh.closed ? std::make_unique<InsideOracle>(baked.shape.mesh)
                                              : nullptr);
  }
  for (const VerifiedProxy& proxy : data.proxies) {
    if ((proxy.flags & kContactNoFreePose) != 0) continue;
    ++out.verified_checked;
    for (size_t i = 0; i < oracles.size(); ++i) {
      const Vec3 g_O = inverse(proxy.X_WO[i]) * proxy.X_WG.p;
      if (oracles[i] != nullptr && oracles[i]->inside(g_O)) ++out.verified_inside;
    }
  }
  for (const ServoFrame& frame : data.frames) {
    if ((frame.flags & kServoContact) == 0) continue;
    const double depth = proxy_depth(frame, scene_of(data.scenes, frame.scene_seq), config, shapes);
    out.deepest_proxy = std::max(out.deepest_proxy, depth);
  }
  return out;
}

std::vector<Row> summarize(const std::string& name, const SessionData& data,
                           const SessionConfig& config, const Penetration& penetration) {
  Rows rows(name);
  const auto& frames = data.frames;
  const auto ticks = static_cast<double>(frames.size());
  const double limit = std::min(config.safety.max_force, config.device.max_force);
  double peak = 0, deepest = 0;
  size_t touching = 0, faults = 0;
  for (const ServoFrame& f : frames) {
    const double force = norm(f.F_device_B.f);
    peak = std::max(peak, force);
    touching += (f.flags & kServoContact) != 0 && force > kTouchForce;
    faults += (f.flags & kServoFault) != 0;
    deepest = std::max(deepest, f.depth);
  }
  const uint64_t skipped = frames.empty() ? 0 : frames.back().skipped - frames.front().skipped;
  rows.add("ticks", ticks, "");
  rows.add("late ticks (grid points skipped)", static_cast<double>(skipped), "");
  rows.add("wake lateness", quantiles_of(frames, [](const auto& f) { return f.wake_late_ns; }));
  rows.add("servo busy", quantiles_of(frames, [](const auto& f) { return f.busy_ns; }));
  rows.add("contact busy", quantiles_of(data.proxies, [](const auto& p) { return p.busy_ns; }));
  if (data.proxies.size() > 1) {
    const auto span =
        static_cast<double>(data.proxies.back().answers_t_ns - data.proxies.front().answers_t_ns);
    rows.add("contact rate", static_cast<double>(data.proxies.size() - 1) / (span * 1e-9), "Hz");
  }
  rows.add("ticks in contact", static_cast<double>(touching), "", 1, touching > 0);
  rows.add("peak force at the device", peak, "N", limit, peak <= limit);
  rows.add("deepest push of the hand behind the surface", deepest, "m");
  rows.add("deepest penetration of this tick's proxy", penetration.deepest_proxy, "m");
  rows.add("verified proxy inside (exact check)", static_cast<double>(penetration.verified_inside),
           "", 0, penetration.verified_inside == 0 && penetration.verified_checked > 0);
  const PortEnergy energy = port_energy(frames);
  rows.add("energy the hand put in", energy.into_device, "J");
  rows.add("energy it got back", energy.returned, "J");
  rows.add("energy balance of the hand (positive: passive)", energy.net(), "J");
  rows.add("ticks in fault", static_cast<double>(faults), "", 0, faults == 0);
  rows.add("samples recorded", ticks, "");
  rows.add("samples lost", static_cast<double>(data.lost), "", 0, data.lost == 0);
  return rows.take();
}

}  // namespace haptic
