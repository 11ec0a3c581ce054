// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "proto/wire/wire.h"

namespace haptic::test {

/// A body as the judge knows it: what its makers say, not what sim has made of it.
struct JudgedBody {
  uint32_t object = 0;
  double mass = 0;
  Vec3 centre_O;
  Mat3 inertia_O;  // about the centre [kg·m²]
};

/// A box of these edges, by the textbook.
inline JudgedBody judged_box(uint32_t object, const Vec3& edges, double mass) {
  const double x = edges.x * edges.x, y = edges.y * edges.y, z = edges.z * edges.z, k = mass / 12;
  return {object, mass, {}, {{{k * (y + z), 0, 0}, {0, k * (x + z), 0}, {0, 0, k * (x + y)}}}};
}

/// The energy of a scene by the poses and twists of its frames alone, averaged over each second.
/// The bound: no such mean is above what there was at the start, plus what was given until then,
/// plus a thousandth of the largest kinetic energy so far.
class EnergyJudge {
 public:
  EnergyJudge(std::vector<JudgedBody> bodies, const Vec3& gravity_W, double rate)
      : bodies_(std::move(bodies)), gravity_W_(gravity_W), steps_(std::lround(rate)) {}

  /// Adds what else stores energy, by the poses of a frame [J].
  void add_store(std::function<double(const SceneFrame&)> store) {
    stores_.push_back(std::move(store));
  }

  double kinetic(const SceneFrame& frame) const {
    double sum = 0;
    for (const JudgedBody& body : bodies_) {
      const Pose& X = frame.objects[body.object].X_WO;
      const Twist& V = frame.objects[body.object].V_WO;
      const Vec3 v = V.v + cross(V.w, rotate(X.q, body.centre_O));
      const Vec3 w_O = rotate(conjugate(X.q), V.w);
      sum += 0.5 * body.mass * dot(v, v) + 0.5 * dot(w_O, body.inertia_O * w_O);
    }
    return sum;
  }
  double stored(const SceneFrame& frame) const {
    double sum = 0;
    for (const JudgedBody& body : bodies_) {
      sum -= body.mass * dot(gravity_W_, frame.objects[body.object].X_WO * body.centre_O);
    }
    for (const auto& store : stores_) sum += store(frame);
    return sum;
  }

  void begin(const SceneFrame& frame) {
    lowest_ = highest_ = start_ = kinetic(frame) + stored(frame);
    largest_kinetic_ = kinetic(frame);
  }
  /// `given`: what others have given since the start [J].
  void add(const SceneFrame& frame, double given = 0) {
    const double now_kinetic = kinetic(frame), energy = now_kinetic + stored(frame) - given;
    largest_kinetic_ = std::max(largest_kinetic_, now_kinetic);
    lowest_ = std::min(lowest_, energy), highest_ = std::max(highest_, energy);
    sum_ += energy;
    if (++n_ < steps_) return;
    last_mean_ = sum_ / static_cast<double>(n_);
    excess_ = std::max(excess_, last_mean_ - start_ - 1e-3 * largest_kinetic_);
    n_ = 0, sum_ = 0;
  }

  double start() const { return start_; }
  double excess() const { return excess_; }  // largest, over the bound; ≤ 0: it holds [J]
  double last_mean() const { return last_mean_; }
  double largest_kinetic() const { return largest_kinetic_; }
  double swing() const { return highest_ - lowest_; }  // of single frames [J]

 private:
  std::vector<JudgedBody> bodies_;
  Vec3 gravity_W_;
  long steps_;
  std::vector<std::function<double(const SceneFrame&)>> stores_;
  double start_ = 0, sum_ = 0, lowest_ = 0, highest_ = 0;
  double largest_kinetic_ = 0, excess_ = -1e300, last_mean_ = 0;
  long n_ = 0;
};

}  // namespace haptic::test
