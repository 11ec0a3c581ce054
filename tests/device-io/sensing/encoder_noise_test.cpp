// SPDX-License-Identifier: GPL-3.0-or-later
// Encoder noise against motion: paths in closed form, and recorded hands.
#include "device-io/sensing/encoder_noise.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <functional>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "device-io/sixmotors/kinematics.h"
#include "proto/math/units.h"
#include "tests/support/data.h"

using haptic::EncoderNoise;
using haptic::kMs;
using haptic::MotorCounts;

namespace {

constexpr double kCount = 33e-6;  // finest count of an encoder, at the tip [m]

using Path = std::function<double(double)>;

/// Ticks until a path is classified as noise; -1: never. `counts_at` makes counts of a place of it.
/// Each sample is taken `sampled_ms` after its question, which is answered a tick after it.
int noisy_after(
    const Path& path, int ticks, const std::function<double()>& sampled_ms = [] { return 0.25; },
    EncoderNoise noise = {},
    MotorCounts (*counts_at)(double at) =
        [](double at) {
          const auto n = static_cast<int32_t>(std::floor(at / kCount));
          return MotorCounts{7, n, -n / 2};
        }) {
  for (int i = 0; i < ticks; ++i) {
    noise.add(counts_at(path(1e-3 * (i + sampled_ms()))), i * kMs, (i + 1) * kMs);
    if (noise.is_noisy()) return i + 1;
  }
  return -1;
}

}  // namespace

TEST_CASE("noise: nothing a hand does is noise", "[device-io]") {
  const double pi2 = 2 * std::numbers::pi;
  const auto sine = [pi2](double amplitude, double hertz) {
    return [=](double t) { return amplitude * std::sin(pi2 * hertz * t); };
  };
  // sampled at any instant between question and answer: velocity errors as large as the velocity
  std::minstd_rand random;
  const auto any = [&random] { return std::uniform_real_distribution<double>(0, 0.999)(random); };
  CHECK(noisy_after(sine(0.1, 10 / pi2), 60'000, any) == -1);  // 10 rad/s, 1 m/s
  CHECK(noisy_after(sine(1e-3, 12), 60'000, any) == -1);       // the strongest tremor
  CHECK(noisy_after(sine(5e-3, 12), 60'000, any) == -1);
  CHECK(noisy_after(sine(1e-3, 50), 60'000, any) == -1);  // a vibrating wall, 98 m/s²
  CHECK(noisy_after([](double) { return 0.0; }, 60'000) == -1);
  // a flickering count
  CHECK(noisy_after([&](double) { return any() * 1.9 * kCount; }, 60'000) == -1);
}

TEST_CASE("noise: a slap of 1.5 m/s that rebounds is not noise", "[device-io]") {
  // half a sine on a wall of 1000 N/m with 0.25 kg, four times a second; the wall at zero
  const double omega = std::sqrt(1000 / 0.25), v = 1.5, touch = std::numbers::pi / omega;
  const auto slap = [=](double t) {
    const double s = std::fmod(t, 0.25) - 0.1;
    if (s < 0) return -v * s;
    if (s < touch) return -v / omega * std::sin(omega * s);
    return v * (s - touch);
  };
  CHECK(noisy_after(slap, 60'000) == -1);
  // and on a stop as hard as steel: one implausible reversal
  const auto stop = [=](double t) { return v * std::fabs(std::fmod(t, 0.25) - 0.1); };
  CHECK(noisy_after(stop, 60'000) == -1);
}

TEST_CASE("noise: of 60 counts is found within 50 ms, of 10 within half a second", "[device-io]") {
  const auto [counts, most] = GENERATE(table<int, int>({{60, 50}, {30, 60}, {15, 200}, {10, 500}}));
  const double speed = GENERATE(0.0, 0.05, 0.2);
  std::minstd_rand random(static_cast<unsigned>(counts));
  int worst = 0;
  for (int i = 0; i < 100; ++i) {
    std::uniform_int_distribution<int> off(-counts, counts);
    const int after =
        noisy_after([&](double t) { return speed * t + kCount * off(random); }, 10'000);
    REQUIRE(after > 0);
    worst = std::max(worst, after);
  }
  CAPTURE(counts, speed);
  CHECK(worst <= most);
}

namespace {

constexpr double kTurnCounts = 5215;  // of a motor of the wrist, per radian

/// As above, but the path is an angle that the last motor of a wrist turns, and the samples are
/// taken at random instants.
int turn_noisy_after(const EncoderNoise& noise, const Path& angle, std::minstd_rand& random) {
  const auto any = [&] { return std::uniform_real_distribution<double>(0, 0.999)(random); };
  return noisy_after(angle, 10'000, any, noise, [](double at) {
    return MotorCounts{0, 0, 0, 0, 0, static_cast<int32_t>(std::floor(at * kTurnCounts))};
  });
}

}  // namespace

TEST_CASE("noise: a wrist turns faster than a tip moves, and its noise is found all the same",
          "[device-io]") {
  const EncoderNoise wrist(haptic::six_motors_arm().most_accelerations());
  std::minstd_rand random;
  // to and fro between samples that may be 2 ms apart takes A = 2 n / (2 ms)²: 30 counts take
  // 2880 rad/s², 36 take 3450; a tip is thought to reach 580
  const auto to_and_fro = [](int counts) {
    return [=](double t) { return (std::fmod(t, 2e-3) < 1e-3 ? 0.5 : counts + 0.5) / kTurnCounts; };
  };
  CHECK(turn_noisy_after(wrist, to_and_fro(30), random) == -1);
  CHECK(turn_noisy_after(wrist, to_and_fro(36), random) > 0);
  constexpr double kTip = haptic::kTipAcceleration;
  const EncoderNoise tip({kTip, kTip, kTip, kTip, kTip, kTip});
  CHECK(turn_noisy_after(tip, to_and_fro(30), random) > 0);
  // noise of 60 counts, 12 mrad, in a hand that turns
  std::uniform_int_distribution<int> off(-60, 60);
  const double speed = GENERATE(0.0, 1.0, 5.0);  // [rad/s]
  int worst = 0;
  for (int i = 0; i < 100; ++i) {
    const auto noisy = [&](double t) { return speed * t + off(random) / kTurnCounts; };
    const int after = turn_noisy_after(wrist, noisy, random);
    REQUIRE(after > 0);
    worst = std::max(worst, after);
  }
  CAPTURE(speed, worst);
  CHECK(worst <= 200);
}

TEST_CASE("noise: it holds until the encoders have been quiet, and one jump is none",
          "[device-io]") {
  EncoderNoise noise;
  int64_t t_ns = 0;
  const auto add = [&](int32_t n) {
    noise.add({n, 0, 0}, t_ns, t_ns + kMs);
    t_ns += kMs;
  };
  for (int i = 0; i < 100; ++i) add(i == 50 ? 16000 : 0);
  CHECK_FALSE(noise.is_noisy());
  for (int i = 0; i < 100; ++i) add(i % 2 == 0 ? 60 : -60);
  CHECK(noise.is_noisy());
  for (int i = 0; i < 200; ++i) add(0);
  CHECK(noise.is_noisy());
  for (int i = 0; i < 100; ++i) add(0);
  CHECK_FALSE(noise.is_noisy());
}

TEST_CASE("noise: a longer time between samples allows a larger turn", "[device-io]") {
  // samples 20 ms apart decide nothing: 5 mm back and forth may be a shaking hand
  EncoderNoise noise;
  for (int i = 0; i < 1000; ++i) {
    noise.add({i % 2 == 0 ? 50 : -50, 0, 0}, 20 * i * kMs, (20 * i + 1) * kMs);
  }
  CHECK_FALSE(noise.is_noisy());
}

namespace {

/// A column of a recording over its first, sampled at 1 kHz with linear interpolation.
std::function<double(double)> column_of(const std::string& path, size_t column, double scale) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  std::vector<std::pair<double, double>> rows;
  while (std::getline(file, line)) {
    std::istringstream text(line);
    std::vector<double> values;
    for (std::string value; std::getline(text, value, ',');) values.push_back(std::stod(value));
    rows.emplace_back(values.front(), scale * values[column]);
  }
  return [rows, next = size_t{1}](double t) mutable {
    while (next + 1 < rows.size() && rows[next].first < t) ++next;
    const auto [t0, x0] = rows[next - 1];
    const auto [t1, x1] = rows[next];
    return x0 + std::clamp((t - t0) / (t1 - t0), 0.0, 1.0) * (x1 - x0);
  };
}

}  // namespace

TEST_CASE("noise: no recorded hand is noise", "[device-io]") {
  constexpr double kLever = 0.075;  // lever arm [m]
  const std::string tue = "tue-1dof-bilateral/", epfl = "epfl-wiping/";
  for (const char* name : {"m2_question1c_foam", "m2_question1c_free_motion", "m2_question1c_rigid",
                           "m2_question1c_spring", "question1a_foam", "question1a_free_motion",
                           "question1a_rigid", "question1a_spring"}) {
    const std::string path = haptic::test::data_file(tue + name + ".csv");
    CAPTURE(name);
    // master and slave
    CHECK(noisy_after(column_of(path, 1, kLever), 5000) == -1);
    CHECK(noisy_after(column_of(path, 2, kLever), 5000) == -1);
  }
  CHECK(noisy_after(column_of(haptic::test::data_file(tue + "handRef.csv"), 1, kLever), 5000) ==
        -1);
  for (const char* name : {"wipe_fender_1", "wipe_rim_1", "wipe_rim_2"}) {
    const std::string path = haptic::test::data_file(epfl + name + ".csv");
    CAPTURE(name);
    for (size_t axis = 1; axis <= 3; ++axis) {
      CHECK(noisy_after(column_of(path, axis, 1), 20'000) == -1);
    }
  }
}
