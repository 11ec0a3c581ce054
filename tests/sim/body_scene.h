// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <deque>
#include <utility>
#include <vector>

#include "contact/shape/baked/mesh_shape.h"
#include "contact/shape/mesh/primitives.h"
#include "proto/config/config.h"
#include "sim/step.h"

namespace haptic::test {

inline constexpr double kGravity = 9.81;  // [m/s²]

/// A scene of bodies with its shapes, and a sim that steps it without a hand.
struct BodyScene {
  SessionConfig config;
  std::deque<MeshShapeData> owned;
  std::vector<MeshShape> shapes;

  BodyScene() { config.sim_rate = 1000; }

  /// A box of these edges [m]; mass 0: it stands still.
  ObjectConfig& add_box(const Vec3& extent, const Pose& X_WO, double mass) {
    const primitive::Box box{extent};
    ObjectConfig& object = add(make_box(box), X_WO, mass);
    object.primitive = box;
    return object;
  }
  ObjectConfig& add(Soup soup, const Pose& X_WO, double mass) {
    owned.push_back(build_shape(std::move(soup)));
    shapes.push_back(owned.back().view());
    ObjectConfig& object = config.objects[config.n_objects++];
    object.X_WO = X_WO;
    object.body.mass = mass;
    return object;
  }
};

/// Steps a scene at its rate.
struct BodySim {
  SimModel model;
  SimState state;
  int64_t period_ns;
  int64_t t_ns = 1'000'000'000;
  SceneFrame frame{};

  explicit BodySim(const BodyScene& scene)
      : model(build_sim(scene.config, scene.shapes)),
        period_ns(std::llround(1e9 / scene.config.sim_rate)) {
    frame = sim_step(model, state, t_ns);
  }
  /// Begins anew with a hand, whose counters go on from here.
  void begin_with(const ServoFrame& hand) {
    state = {};
    frame = sim_step(model, state, {&hand}, t_ns);
  }
  const SceneFrame& step(const ServoFrame* hand = nullptr) {
    t_ns += period_ns;
    frame = sim_step(model, state, {hand}, t_ns);
    return frame;
  }
};

}  // namespace haptic::test
