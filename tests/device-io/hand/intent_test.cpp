// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/hand/intent.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <set>

#include "tests/support/near.h"

using namespace haptic;
using haptic::test::IsNear;
using haptic::test::kAlgebra;
using haptic::test::tol;

namespace {

constexpr double kCycles = 40;

IntentConfig calm() {
  IntentConfig config;
  config.centre_B = {0.01, -0.02, 0.03};
  config.tremor_amplitude = 0;
  return config;
}

double cycle_of(const IntentConfig& config) {
  return 1.5 * config.stroke_time;
}

/// FNV-1a over the bits of these numbers.
void add_bits(uint64_t& hash, std::initializer_list<double> numbers) {
  for (const double number : numbers) {
    unsigned char bytes[sizeof number];
    std::memcpy(bytes, &number, sizeof number);
    for (const unsigned char byte : bytes) hash = (hash ^ byte) * 1099511628211u;
  }
}

/// Hash of the positions and velocities; `turns`: of the orientations and angular velocities.
uint64_t hash_of(const IntentConfig& config, uint64_t seed, bool turns = false) {
  uint64_t hash = 14695981039346656037u;
  for (int i = 0; i < 5000; ++i) {
    const Intent intent = intent_at(config, seed, 0.0137 * i);
    const Vec3 &p = intent.p_B, &v = intent.v_B, &w = intent.w_B;
    const Quat& q = intent.q_B;
    if (turns) {
      add_bits(hash, {q.x, q.y, q.z, q.w, w.x, w.y, w.z});
    } else {
      add_bits(hash, {p.x, p.y, p.z, v.x, v.y, v.z});
    }
  }
  return hash;
}

}  // namespace

TEST_CASE("intent: a stroke visits the documented places", "[device-io]") {
  const IntentConfig config = calm();
  const double T = config.stroke_time;
  for (int k = 0; k < 50; ++k) {
    const double start = k * cycle_of(config);
    const auto arm = [&](double t) {
      return intent_at(config, 7, start + t).p_B - config.centre_B;
    };
    const Vec3 u1 = arm(1e-9) / config.hover_radius;
    const Vec3 u2 = arm(T) / config.hover_radius;
    CAPTURE(k);
    REQUIRE(norm(u1) == Approx(1).margin(kAlgebra));
    REQUIRE_THAT(arm(T / 4), IsNear(config.press_radius * u1, 1e-9));
    REQUIRE_THAT(arm(3 * T / 4), IsNear(config.press_radius * u2, 1e-9));
    REQUIRE(std::acos(dot(u1, u2)) == Approx(config.stroke_angle).margin(tol(1e-9)));
    // halfway through a minimum-jerk slide half the angle is done
    REQUIRE_THAT(arm(T / 2), IsNear(config.press_radius * normalized(u1 + u2), 1e-9));
  }
}

TEST_CASE("intent: the velocity is the derivative of the position and has no jump", "[device-io]") {
  IntentConfig config = calm();
  config.tremor_amplitude = GENERATE(0.0, 1e-4);
  const double h = 1e-5;
  // the tremor's own a·h²ω³/6 and the strokes' third derivative 60·0.22 m/(0.6 s)³ times h²/6
  constexpr double kDifferenceError = 2e-9;
  // largest acceleration: 5.8·0.22 m/(0.6 s)² of travel, 0.6 m/s² of tremor; a jump would exceed it
  const double steepest = 2 * h * 6;
  Intent before = intent_at(config, 3, 0);
  for (double t = h; t < kCycles / 4 * cycle_of(config); t += 100 * h) {
    CAPTURE(t);
    before = intent_at(config, 3, t - h);
    const Intent at = intent_at(config, 3, t), after = intent_at(config, 3, t + h);
    REQUIRE_THAT(at.v_B, IsNear((after.p_B - before.p_B) / (2 * h), kDifferenceError + h * 0.001));
    REQUIRE(norm(after.v_B - before.v_B) < steepest);
  }
  // and across every boundary of a cycle
  for (int k = 0; k < 200; ++k) {
    for (const double share : {0.0, 0.25, 0.75, 1.0}) {
      const double seam = k * cycle_of(config) + share * config.stroke_time;
      const Intent left = intent_at(config, 3, std::max(0.0, seam - h));
      const Intent right = intent_at(config, 3, seam + h);
      CAPTURE(k, share);
      REQUIRE(norm(right.v_B - left.v_B) < steepest);
      REQUIRE(norm(right.p_B - left.p_B) < 2 * h * 0.05);
    }
  }
}

TEST_CASE("intent: it never cuts through the ball between strokes", "[device-io]") {
  const IntentConfig config = calm();
  double shortest = 1, longest = 0;
  std::set<IntentPart> seen;
  for (double t = 0; t < kCycles * cycle_of(config); t += 0.0021) {
    const double radius = norm(intent_at(config, 11, t).p_B - config.centre_B);
    const IntentPart part = intent_phase(config, t).part;
    seen.insert(part);
    if (part == IntentPart::kTravel) {
      REQUIRE(std::fabs(radius - config.hover_radius) <= tol(kAlgebra));
    }
    shortest = std::min(shortest, radius);
    longest = std::max(longest, radius);
  }
  CHECK(seen.size() == 4);
  CHECK(shortest == Approx(config.press_radius).margin(tol(kAlgebra)));
  CHECK(longest == Approx(config.hover_radius).margin(tol(kAlgebra)));
}

TEST_CASE("intent: the directions of the strokes are uniform on the sphere", "[device-io]") {
  const IntentConfig config = calm();
  constexpr int kStrokes = 4000;
  Vec3 mean, squares;
  for (int k = 0; k < kStrokes; ++k) {
    const Vec3 u = (intent_at(config, 5, (k + 1e-7) * cycle_of(config)).p_B - config.centre_B) /
                   config.hover_radius;
    mean += u / kStrokes;
    squares += Vec3{u.x * u.x, u.y * u.y, u.z * u.z} / kStrokes;
  }
  // four standard errors: √(1/3)/√n of a coordinate, √(4/45)/√n of its square
  CHECK_THAT(mean, IsNear({}, 4 * std::sqrt(3.0) * 0.577 / std::sqrt(kStrokes)));
  CHECK_THAT(squares, IsNear(Vec3{1, 1, 1} / 3, 4 * std::sqrt(3.0) * 0.298 / std::sqrt(kStrokes)));
}

TEST_CASE("intent: the tremor stays below its amplitude and within 8 to 12 Hz", "[device-io]") {
  IntentConfig config = calm();
  config.tremor_amplitude = 1e-4;
  for (uint64_t seed = 0; seed < 8; ++seed) {
    Vec3 previous;
    int crossings[3] = {};
    constexpr double kSeconds = 20, kStep = 1e-3;
    for (double t = 0; t < kSeconds; t += kStep) {
      const Vec3 shake = intent_at(config, seed, t).p_B - intent_at(calm(), seed, t).p_B;
      REQUIRE(norm(shake) <= config.tremor_amplitude * (1 + kAlgebra) + 1e-16);
      for (int i = 0; i < 3; ++i) crossings[i] += shake[i] * previous[i] < 0 ? 1 : 0;
      previous = shake;
    }
    for (const int count : crossings) {
      CHECK(count >= 2 * 8 * kSeconds - 1);
      CHECK(count <= 2 * 12 * kSeconds + 1);
    }
  }
}

TEST_CASE("intent: one seed gives one motion, to the bit, and another seed another",
          "[device-io]") {
  const IntentConfig config;
  CHECK(hash_of(config, 1) == hash_of(config, 1));
  CHECK(hash_of(config, 1) != hash_of(config, 2));
  // pinned: every machine and compiler must give these bits
  CHECK(hash_of(config, 1) == 0x8d980e6de298c723u);
}

TEST_CASE("intent: before the start it rests at the beginning", "[device-io]") {
  const IntentConfig config;
  CHECK(intent_at(config, 1, -3).p_B == intent_at(config, 1, 0).p_B);
  CHECK(intent_at(config, 1, -3).v_B == Vec3{});
}

TEST_CASE("intent: with a direction and no arc the hand presses on one spot", "[device-io]") {
  IntentConfig config = calm();
  config.direction_B = {0, 0.6, 0.8};
  config.stroke_angle = 0;
  for (int i = 0; i < 1000; ++i) {
    const double t = 0.0137 * i;
    const Vec3 arm_B = intent_at(config, 3, t).p_B - config.centre_B;
    REQUIRE_THAT(normalized(arm_B), IsNear(config.direction_B, kAlgebra));
    const IntentPhase phase = intent_phase(config, t);
    if (phase.part == IntentPart::kSlide) {
      REQUIRE(norm(arm_B) == Approx(config.press_radius).epsilon(tol(kAlgebra)));
    } else if (phase.part == IntentPart::kTravel) {
      REQUIRE(norm(arm_B) == Approx(config.hover_radius).epsilon(tol(kAlgebra)));
    }
  }
}

TEST_CASE("intent: a turn leaves the positions as they are, to the bit", "[device-io]") {
  IntentConfig config;
  const uint64_t alone = hash_of(config, 1);
  config.turn_angle = 0.4;
  CHECK(hash_of(config, 1) == alone);
  CHECK(hash_of(config, 1, true) != hash_of(config, 2, true));
  // pinned: every machine and compiler must give these bits
  CHECK(hash_of(config, 1, true) == 0x6818d56947bf0ed9u);
}

TEST_CASE("intent: the handle turns while it slides, by the angle, and back while it travels",
          "[device-io]") {
  IntentConfig config;
  config.turn_angle = 0.5;
  const bool has_axis = GENERATE(false, true);
  if (has_axis) config.turn_axis_B = {0, 0.6, -0.8};
  bool to_one_side = false, to_the_other = false;
  for (int stroke = 0; stroke < 30; ++stroke) {
    const double begin = stroke * 1.5 * config.stroke_time;
    const auto turned = [&](double share) {
      return to_rotation_vector(intent_at(config, 7, begin + share * config.stroke_time).q_B);
    };
    CHECK(norm(turned(0.01)) == 0);
    CHECK(norm(turned(0.25)) <= tol(1e-12));
    const Vec3 whole = turned(0.76);
    CHECK(norm(whole) == Approx(0.5).epsilon(1e-12));
    CHECK_THAT(turned(0.99), IsNear(whole, 1e-12));
    CHECK_THAT(turned(0.5), IsNear(whole / 2, 1e-12));
    CHECK_THAT(turned(1.25), IsNear(whole / 2, 1e-12));
    CHECK(norm(turned(1.4999999)) <= 1e-9);
    if (has_axis) CHECK(norm(cross(whole, config.turn_axis_B)) <= tol(1e-12));
    to_one_side |= dot(whole, config.turn_axis_B) > 0;
    to_the_other |= dot(whole, config.turn_axis_B) < 0;
  }
  CHECK(to_one_side == has_axis);
  CHECK(to_the_other == has_axis);
}

TEST_CASE("intent: the angular velocity is the derivative of the orientation, without steps",
          "[device-io]") {
  IntentConfig config;
  config.turn_angle = 1.2;
  constexpr double kStep = 1e-6;  // [s]
  Vec3 before_B;
  for (int i = 1; i < 40000; ++i) {
    const double t = 2.5e-4 * i;
    const Quat from = intent_at(config, 3, t - kStep).q_B, to = intent_at(config, 3, t + kStep).q_B;
    const Vec3 w_B = intent_at(config, 3, t).w_B;
    // the third derivative is below 60·1.2/0.6³, and rounding of 1e-16 over the step
    REQUIRE_THAT(to_rotation_vector(to * conjugate(from)) / (2 * kStep), IsNear(w_B, 1e-8));
    // peak acceleration 5.77·angle/time², over the sampling
    REQUIRE(norm(w_B - before_B) <= 5.8 * 1.2 / (0.6 * 0.6) * 2.5e-4);
    before_B = w_B;
  }
}
