// SPDX-License-Identifier: Apache-2.0
// A simulated device in a simulated hand, in place of a vendor's library. With $STAND_IN_SDK_LOG it
// writes down each wrench that it is given: t [ns], force [N], torque [N·m], place [m], rotation
// vector [rad].
#include <stand_in_sdk.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>

namespace sdk {
namespace {

using Axes = std::array<double, 6>;  // place, then rotation vector

/// A typical hand on a light handle, moving and turning: guesses.
struct Hand {
  double inertia, damping, stiffness;
};
constexpr Hand kMoves{0.75, 6, 300};      // [kg, N·s/m, N/m]
constexpr Hand kTurns{1.1e-3, 0.025, 2};  // [kg·m², N·m·s/rad, N·m/rad]
constexpr double kStep = 1e-4;            // of the integration [s]
constexpr double kMostPassed = 0.05;      // simulated at once, after a pause of the caller [s]
constexpr double kStroke = 4, kMiddle = 0.01, kSwing = 0.02;  // of the hand [s, m, m]
constexpr double kTilt = 0.1;                                 // about x [rad]

Axes at{0, 0, kMiddle + kSwing}, speed{}, wrench{};
double t = 0;  // simulated [s]
std::chrono::steady_clock::time_point last;
std::FILE* log_file = nullptr;

/// Where the hand means to be.
Axes meant(double time) {
  const double phase = 2 * std::numbers::pi * time / kStroke;
  return {0, 0, kMiddle + kSwing * std::cos(phase), kTilt * std::sin(phase), 0, 0};
}

void step() {
  const Axes goal = meant(t);
  for (size_t i = 0; i < at.size(); ++i) {
    const Hand& hand = i < 3 ? kMoves : kTurns;
    const double push = hand.stiffness * (goal[i] - at[i]) - hand.damping * speed[i] + wrench[i];
    speed[i] += kStep / hand.inertia * push;
    at[i] += kStep * speed[i];
  }
  t += kStep;
}

void pass_time() {
  const auto now = std::chrono::steady_clock::now();
  const double passed = std::chrono::duration<double>(now - last).count();
  const double until = t + std::fmin(passed, kMostPassed);
  while (t + kStep <= until) step();
  // what is left of a step is not lost
  last = now - std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                   std::chrono::duration<double>(until - t));
}

}  // namespace

bool open() {
  last = std::chrono::steady_clock::now();
  const char* name = std::getenv("STAND_IN_SDK_LOG");
  if (name != nullptr) log_file = std::fopen(name, "w");
  return name == nullptr || log_file != nullptr;
}

void close() {
  wrench = {};
  if (log_file != nullptr) std::fclose(log_file);
  log_file = nullptr;
}

bool get_pose(double p[3], double R[9]) {
  pass_time();
  const double x = at[3], y = at[4], z = at[5], angle = std::hypot(x, y, z);
  const double a = angle > 0 ? std::sin(angle) / angle : 1;
  const double b = angle > 0 ? (1 - std::cos(angle)) / (angle * angle) : 0.5;
  // Rodrigues: R = I + a [r]× + b [r]×²
  const double rows[9] = {
      1 - b * (y * y + z * z), b * x * y - a * z,       b * x * z + a * y,
      b * x * y + a * z,       1 - b * (x * x + z * z), b * y * z - a * x,
      b * x * z - a * y,       b * y * z + a * x,       1 - b * (x * x + y * y)};
  for (int i = 0; i < 9; ++i) R[i] = rows[i];
  for (size_t i = 0; i < 3; ++i) p[i] = at[i];
  return true;
}

unsigned get_buttons() {
  return at[2] < 0 ? 1 : 0;  // pressed while the hand is below z = 0
}

bool set_force_and_torque(const double f[3], const double torque[3]) {
  pass_time();
  for (size_t i = 0; i < 3; ++i) {
    wrench[i] = f[i];
    wrench[3 + i] = torque[i];
  }
  if (log_file == nullptr) return true;
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  std::fprintf(log_file, "%lld", static_cast<long long>(std::chrono::nanoseconds(now).count()));
  for (const Axes* axes : {&wrench, &at}) {
    for (const double value : *axes) std::fprintf(log_file, ",%.6g", value);
  }
  std::fputc('\n', log_file);
  std::fflush(log_file);
  return true;
}

}  // namespace sdk
