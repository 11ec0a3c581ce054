// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/replay/replay.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>

#include "proto/config/devices.h"
#include "proto/math/units.h"
#include "tests/support/data.h"
#include "tests/support/near.h"

using namespace haptic;
using haptic::test::IsNear;
using haptic::test::kAlgebra;
using haptic::test::tol;

namespace {

constexpr double kGap = 0.02;

/// A hand that swings and turns slowly enough for a camera at 75 Hz.
Vec3 position_on_way(double t) {
  return {0.05 * std::sin(2 * kPi * t), 0.03 * std::cos(2 * kPi * 0.7 * t), 0.1 * t};
}
Vec3 velocity(double t) {
  return {0.05 * 2 * kPi * std::cos(2 * kPi * t),
          -0.03 * 2 * kPi * 0.7 * std::sin(2 * kPi * 0.7 * t), 0.1};
}
const Vec3 kSpin{0.8, -1.1, 2.0};  // constant, so that slerp is exact [rad/s]

DeviceState sample_at(int64_t t_ns) {
  const double t = 1e-9 * static_cast<double>(t_ns);
  DeviceState sample{};
  sample.t_ns = t_ns;
  // rotated at the start, so that B and H differ
  sample.X_BH = {position_on_way(t),
                 from_rotation_vector(t * kSpin) * from_rotation_vector({1, 2, -1})};
  sample.flags = kDeviceFresh | kDeviceHomed;
  return sample;
}

std::vector<DeviceState> recording(int64_t step_ns, int count, int64_t start_ns = 0) {
  std::vector<DeviceState> samples;
  for (int i = 0; i < count; ++i) samples.push_back(sample_at(start_ns + i * step_ns));
  return samples;
}

Vec3 rotation_between(const Quat& a, const Quat& b) {
  return to_rotation_vector(b * conjugate(a));
}

}  // namespace

TEST_CASE("replay: a sample on the grid comes back bit for bit", "[device-io]") {
  // 2 kHz, an odd start, one with its own twist and buttons
  std::vector<DeviceState> samples = recording(500'000, 400, 123'456'789);
  for (DeviceState& sample : samples) {
    sample.V_BH = {{0.1, 0.2, 0.3}, {1, 2, 3}};
    sample.buttons = 5;
    sample.grip = 0.25;
  }
  Replay replay(HandCurve(samples, Resampling::kCubic, kGap), 8);
  for (int k = 0; k < 200; ++k) {
    DeviceState state{};
    // a late wake-up does not distort the trace
    const int64_t deadline_ns = 9'000'000'000 + k * kMs;
    REQUIRE(replay.read({deadline_ns, deadline_ns + 300'000}, state));
    const DeviceState& sample = samples[static_cast<size_t>(2 * k)];
    REQUIRE(state.X_BH == sample.X_BH);
    REQUIRE(state.V_BH == sample.V_BH);
    REQUIRE(state.buttons == 5);
    REQUIRE(state.grip == 0.25);
    REQUIRE(state.t_ns == deadline_ns);
    REQUIRE(state.flags == (kDeviceFresh | kDeviceHomed | kDeviceOpenLoop));
  }
}

TEST_CASE("replay: a clock a microsecond off the samples still meets them exactly", "[device-io]") {
  const auto samples = recording(kMs, 50);
  const HandCurve curve(samples, Resampling::kCubic, kGap);
  const int64_t off_ns = GENERATE(-1000, -1, 0, 1, 1000);
  for (size_t i = 1; i + 1 < samples.size(); ++i) {
    REQUIRE(curve.at(samples[i].t_ns + off_ns).X_BH == samples[i].X_BH);
  }
  CHECK_FALSE(curve.at(samples[3].t_ns + 1001).X_BH == samples[3].X_BH);
}

TEST_CASE("replay: 75 Hz becomes 1 kHz with cubic error", "[device-io]") {
  const int64_t period_ns = 1'000'000'000 / 75;
  // the time stamps of a real recording are uneven
  const bool uneven = GENERATE(false, true);
  std::vector<DeviceState> samples;
  for (int i = 0; i < 225; ++i) {
    samples.push_back(sample_at(i * period_ns + (uneven ? 1'500'000 * ((i * 7) % 3 - 1) : 0)));
  }
  const HandCurve curve(samples, Resampling::kCubic, 0.03);
  double worst_p = 0, worst_v = 0, worst_q = 0, worst_w = 0;
  for (int64_t t_ns = samples[2].t_ns; t_ns < samples[222].t_ns; t_ns += kMs) {
    const DeviceState state = curve.at(t_ns);
    REQUIRE((state.flags & kDeviceFresh) != 0);
    // within a microsecond of a sample, the sample's own time is used
    REQUIRE(std::abs(state.t_ns - t_ns) <= 1000);
    const double t = 1e-9 * static_cast<double>(state.t_ns);
    worst_p = std::max(worst_p, norm(state.X_BH.p - position_on_way(t)));
    worst_v = std::max(worst_v, norm(state.V_BH.v - velocity(t)));
    worst_q = std::max(worst_q, norm(rotation_between(sample_at(state.t_ns).X_BH.q, state.X_BH.q)));
    worst_w = std::max(worst_w, norm(state.V_BH.w - kSpin));
  }
  CAPTURE(worst_p, worst_v, worst_q, worst_w);
  // slopes err by h²·A·ω³/6, at mid-interval that makes h/4 of it: 0.7 µm even, 1.4 µm at 1.22 h
  const double h = 1.25e-9 * static_cast<double>(period_ns);
  const double slope_error = h * h * 0.05 * std::pow(2 * kPi, 3) / 6 * 1.1;
  CHECK(worst_p < slope_error * h / 4);
  CHECK(worst_v < slope_error);
  CHECK(worst_q < tol(1e-11));
  CHECK(worst_w < tol(1e-10));
}

TEST_CASE("replay: halving the sample period divides the error of the cubic by eight or more",
          "[device-io]") {
  const auto worst = [](int64_t step_ns) {
    const auto samples = recording(step_ns, static_cast<int>(2'000'000'000 / step_ns));
    const HandCurve curve(samples, Resampling::kCubic, 1);
    double error = 0;
    for (int64_t t_ns = 200 * kMs; t_ns < 1800 * kMs; t_ns += 333'333) {
      const DeviceState state = curve.at(t_ns);
      const Vec3 truth = position_on_way(1e-9 * static_cast<double>(state.t_ns));
      error = std::max(error, norm(state.X_BH.p - truth));
    }
    return error;
  };
  CHECK(worst(20 * kMs) / worst(10 * kMs) > 7.5);
}

TEST_CASE("replay: the twist is the finite difference of the poses it shows", "[device-io]") {
  const auto samples = recording(10 * kMs, 100);
  const HandCurve curve(samples, Resampling::kCubic, kGap);
  constexpr int64_t kHalf_ns = 10'000;
  // second derivative jumps at a knot: stay inside an interval; third derivative·h²/6 is 1e-9
  for (int64_t t_ns = 203 * kMs; t_ns < 800 * kMs; t_ns += 10 * kMs) {
    const DeviceState before = curve.at(t_ns - kHalf_ns), at = curve.at(t_ns),
                      after = curve.at(t_ns + kHalf_ns);
    const double dt = 2e-9 * kHalf_ns;
    REQUIRE_THAT(at.V_BH.v, IsNear((after.X_BH.p - before.X_BH.p) / dt, 1e-7));
    REQUIRE_THAT(at.V_BH.w, IsNear(rotation_between(before.X_BH.q, after.X_BH.q) / dt, 1e-7));
  }
}

TEST_CASE("replay: position and velocity do not jump at a sample", "[device-io]") {
  const auto samples = recording(13 * kMs, 80);
  const HandCurve curve(samples, Resampling::kCubic, kGap);
  for (size_t i = 1; i + 1 < samples.size(); ++i) {
    const DeviceState left = curve.at(samples[i].t_ns - 2000), at = curve.at(samples[i].t_ns),
                      right = curve.at(samples[i].t_ns + 2000);
    // 2 µs at 0.4 m/s and, with an acceleration of 2 m/s², 4 µm/s
    REQUIRE(norm(right.X_BH.p - left.X_BH.p) < 4e-6 * 0.5);
    REQUIRE(norm(right.V_BH.v - at.V_BH.v) < 3e-5);
    REQUIRE(norm(at.V_BH.v - left.V_BH.v) < 3e-5);
  }
}

TEST_CASE("replay: a hole is held, flagged, and left again", "[device-io]") {
  std::vector<DeviceState> samples = recording(kMs, 100);
  samples.erase(samples.begin() + 40, samples.begin() + 80);  // 39 → 80: 41 ms
  Replay replay(HandCurve(samples, Resampling::kCubic, kGap), 8);
  for (int k = 0; k < 100; ++k) {
    DeviceState state{};
    const bool fresh = replay.read({k * kMs, k * kMs}, state);
    const bool in_hole = k > 39 && k < 80;
    CAPTURE(k);
    REQUIRE(fresh == !in_hole);
    REQUIRE(((state.flags & kDeviceHeld) != 0) == in_hole);
    REQUIRE((state.flags & kDeviceEnded) == 0);
    REQUIRE((state.flags & kDeviceOpenLoop) != 0);
    REQUIRE(state.X_BH == sample_at((in_hole ? 39 : k) * kMs).X_BH);
    if (!in_hole) continue;
    REQUIRE(state.V_BH == Twist{});
    REQUIRE(state.t_ns == 39 * kMs);  // the time of that pose
  }
}

TEST_CASE("replay: slopes do not look across a hole", "[device-io]") {
  // at rest, then a gap in which the hand moved elsewhere
  std::vector<DeviceState> samples;
  for (int i = 0; i < 10; ++i) samples.push_back(sample_at(i * kMs));
  for (DeviceState& sample : samples) sample.X_BH = {{0.1, 0, 0}, {}};
  samples.push_back(sample_at(500 * kMs));
  samples.push_back(sample_at(501 * kMs));
  const HandCurve curve(samples, Resampling::kCubic, kGap);
  CHECK_THAT(curve.at(8 * kMs + 500'000).X_BH.p, IsNear({0.1, 0, 0}, kAlgebra));
  CHECK_THAT(curve.at(9 * kMs).V_BH.v, IsNear({}, kAlgebra));
}

TEST_CASE("replay: after the last sample it says so and stands still", "[device-io]") {
  const auto samples = recording(kMs, 10);
  Replay replay(HandCurve(samples, Resampling::kCubic, kGap), 8);
  DeviceState state{};
  REQUIRE(replay.read({0, 0}, state));
  REQUIRE(replay.read({9 * kMs, 9 * kMs}, state));
  CHECK((state.flags & kDeviceEnded) == 0);
  CHECK_FALSE(replay.read({10 * kMs, 10 * kMs}, state));
  CHECK(state.flags == (kDeviceHomed | kDeviceOpenLoop | kDeviceHeld | kDeviceEnded));
  CHECK(state.X_BH == samples.back().X_BH);
  CHECK(state.V_BH == Twist{});
}

TEST_CASE("replay: orientation takes the shorter way across the double cover", "[device-io]") {
  auto samples = recording(10 * kMs, 100);
  const HandCurve plain(samples, Resampling::kCubic, kGap);
  // −q is the same orientation
  for (size_t i = 0; i < samples.size(); i += 3) {
    Quat& q = samples[i].X_BH.q;
    q = {-q.x, -q.y, -q.z, -q.w};
  }
  const HandCurve flipped(samples, Resampling::kCubic, kGap);
  for (int64_t t_ns = 0; t_ns < 990 * kMs; t_ns += 777'777) {
    const DeviceState a = plain.at(t_ns), b = flipped.at(t_ns);
    REQUIRE_THAT(rotation_between(a.X_BH.q, b.X_BH.q), IsNear({}, 1e-10));
    REQUIRE_THAT(b.V_BH.w, IsNear(kSpin, 1e-9));
  }
}

TEST_CASE("replay: holding shows every sample until the next one", "[device-io]") {
  const auto samples = recording(10 * kMs, 20);
  const HandCurve curve(samples, Resampling::kHold, kGap);
  for (int64_t t = 0; t < 190; ++t) {
    REQUIRE(curve.at(t * kMs).X_BH == samples[static_cast<size_t>(t / 10)].X_BH);
    REQUIRE((curve.at(t * kMs).flags & kDeviceFresh) != 0);
  }
}

TEST_CASE("replay: the force has no effect and people are told so", "[device-io]") {
  std::vector<DeviceState> samples = recording(10 * kMs, 101);
  samples.erase(samples.begin() + 40, samples.begin() + 50);
  Replay pushed(HandCurve(samples, Resampling::kCubic, kGap), 8);
  Replay free(HandCurve(samples, Resampling::kCubic, kGap), 8);
  for (int k = 0; k < 200; ++k) {
    DeviceState a{}, b{};
    pushed.read({k * kMs, k * kMs}, a);
    pushed.write({{8, 8, 8}, {}});
    free.read({k * kMs, k * kMs}, b);
    REQUIRE(a.X_BH == b.X_BH);
  }
  CHECK(pushed.caps().open_loop);
  CHECK(
      pushed.description() ==
      "open-loop replay: 91 samples, 1.0 s, 90.0 Hz; resampled by cubic and slerp, samples on the "
      "grid exact; 1 holes over 20 ms held");
}

TEST_CASE("replay: a real recorded hand opens as a device and is met on its own grid",
          "[device-io][data]") {
  DeviceConfig config;
  config.kind = DeviceKind::kReplay;
  assign(config.replay.path, test::data_file("tue-1dof-bilateral/question1a_rigid.csv"));
  assign(config.replay.column, "master_rad");
  config.replay.lever_arm = 0.075;
  const auto samples = load_hand_trace(config.replay).samples;
  const auto device = open_device(config);
  // 2 kHz on a 1 kHz grid: every other sample
  DeviceState state{};
  for (size_t i = 0; i < samples.size(); i += 2) {
    const auto t_ns = static_cast<int64_t>(i) * kMs / 2;
    REQUIRE(device->read({t_ns, t_ns}, state));
    REQUIRE(state.X_BH == samples[i].X_BH);
    REQUIRE(norm(state.V_BH.v) < 2);
  }
  CHECK_FALSE(device->read({60'000 * kMs, 60'000 * kMs}, state));
  CHECK((state.flags & kDeviceEnded) != 0);
}
