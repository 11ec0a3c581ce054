// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/penalty_artefacts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "clients/lockstep.h"
#include "clients/scripted_hand.h"
#include "contact/shape/mesh_shape.h"
#include "contact/shape/primitives.h"

namespace haptic {
namespace {

constexpr double kSize = 0.1;            // of the block with the edge [m]
constexpr double kEdgeStiffness = 1000;  // [N/m]
constexpr double kEdgeDepth = 2e-3;      // below both faces [m]
constexpr double kPlate = 4e-3;          // thickness [m]
constexpr double kPlateStiffness = 400;  // [N/m]
constexpr double kBeyond = 2e-3;         // how far the tool goes past the plate [m]
constexpr double kPress = 0.1;           // until the tool is as deep as it shall be [s]
constexpr double kWithin = 0.01;         // of the closed form

struct Sample {
  Vec3 tool_W, force;
};

using Path = std::function<Vec3(double)>;

/// What the hand on the path feels, answered within the tick.
std::vector<Sample> feel(Renderer renderer, double stiffness, const Vec3& extent, Path path,
                         double seconds) {
  SessionConfig config = plain_session(stiffness);
  config.renderer = renderer;
  const MeshShapeData owned = build_shape(make_box(extent));
  const std::array<MeshShape, 1> shapes{owned.view()};
  ScriptedHand hand(std::move(path));
  Lockstep lockstep(config, shapes, hand, {1, 0});
  std::vector<Sample> samples;
  for (int k = 0; k < static_cast<int>(seconds * config.servo_rate) && lockstep.step(); ++k) {
    samples.push_back({lockstep.frame().X_WT.p, lockstep.frame().F_device_B.f});
  }
  return samples;
}

/// From above the top onto the depth, then across the bisector to the side face.
Vec3 across_the_edge(double t) {
  const double lift = 0.1 * std::max(0.0, kPress - t), way = 2e-3 * std::max(0.0, t - kPress);
  return {0.5 * kSize - kEdgeDepth - 0.5e-3 + way, 0.003, 0.5 * kSize - kEdgeDepth + lift};
}

struct Jump {
  double newton = 0, degrees = 0;
  double over_way = 0;  // over stiffness times the way of the tool
};

/// The largest changes from tick to tick once the tool is deep.
Jump largest_jump(const std::vector<Sample>& samples) {
  Jump jump;
  for (size_t i = 1; i < samples.size(); ++i) {
    const Vec3 &before = samples[i - 1].force, &now = samples[i].force;
    const double way = norm(samples[i].tool_W - samples[i - 1].tool_W);
    if (samples[i].tool_W.z > 0.5 * kSize - kEdgeDepth + 1e-9 || !(way > 0)) continue;
    const double step = norm(now - before);
    const double turn = std::atan2(norm(cross(before, now)), dot(before, now));
    jump.newton = std::max(jump.newton, step);
    jump.degrees = std::max(jump.degrees, turn * 180 / 3.141592653589793);
    jump.over_way = std::max(jump.over_way, step / (kEdgeStiffness * way));
  }
  return jump;
}

void add_near(Rows& rows, const std::string& metric, double value, const std::string& unit,
              double exact) {
  rows.add(metric, value, unit, exact, std::fabs(value - exact) <= kWithin * std::fabs(exact));
}

std::vector<Row> measure_edge() {
  Rows rows("edge");
  const Vec3 block{kSize, kSize, kSize};
  const auto jump_of = [&](Renderer renderer) {
    return largest_jump(feel(renderer, kEdgeStiffness, block, across_the_edge, 0.6));
  };
  const Jump penalty = jump_of(Renderer::kPenalty3), god = jump_of(Renderer::kGodObject3);
  add_near(rows, "edge, penalty3, force steps by", penalty.newton, "N",
           std::sqrt(2.0) * kEdgeStiffness * kEdgeDepth);
  add_near(rows, "edge, penalty3, force turns by", penalty.degrees, "deg", 90);
  rows.add("edge, god-object3, force steps by", god.newton, "N");
  rows.add("edge, god-object3, step over k times the way", god.over_way, "", 1,
           god.over_way <= 1 + 1e-6);
  return rows.rows();
}

std::vector<Row> measure_plate() {
  Rows rows("plate");
  const auto through = [](double t) { return Vec3{0.001, 0.002, 0.5 * kPlate + 1e-3 - 0.02 * t}; };
  const auto pressed = [&](Renderer renderer) {
    const double seconds = (1e-3 + kPlate + kBeyond) / 0.02 + 2e-3;
    return feel(renderer, kPlateStiffness, {0.2, 0.2, kPlate}, through, seconds);
  };
  const std::vector<Sample> penalty = pressed(Renderer::kPenalty3),
                            god = pressed(Renderer::kGodObject3);
  double most = 0, least = 0;
  for (const Sample& s : penalty) {
    most = std::max(most, s.force.z);
    least = std::min(least, s.force.z);
  }
  const double ceiling = 0.5 * kPlateStiffness * kPlate;
  const double depth = 0.5 * kPlate - god.back().tool_W.z;
  add_near(rows, "plate, penalty3, resists with at most", most, "N", ceiling);
  add_near(rows, "plate, penalty3, helps through with", -least, "N", ceiling);
  rows.add("plate, penalty3, 2 mm beyond", penalty.back().force.z, "N", 0,
           penalty.back().force == Vec3{});
  add_near(rows, "plate, god-object3, 2 mm beyond", god.back().force.z, "N",
           kPlateStiffness * depth);
  return rows.rows();
}

}  // namespace

std::vector<Row> measure_penalty_artefacts() {
  Rows rows("penalty artefacts");
  rows.append(measure_edge());
  rows.append(measure_plate());
  return rows.rows();
}

}  // namespace haptic
