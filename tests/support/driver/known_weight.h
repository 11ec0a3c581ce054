// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string_view>

#include "proto/config/device_config.h"
#include "proto/math/pose.h"
#include "tests/support/driver/rows.h"

namespace haptic::test {

/// Masses of the arm of a driver (DriverRow::name): guesses, such that it weighs about a newton or
/// two at the handle.
GravityConfig known_masses(std::string_view driver);
/// The same, each mass `times` as heavy.
GravityConfig times(double factor, GravityConfig gravity);

/// Potential energy of that arm with its handle at X_BH [J]. Its joints are found from their places
/// in space, as where circles meet or by bisection, from the lengths in the descriptions of the
/// devices; no angle and no formula is the driver's.
double weight_energy(std::string_view driver, const GravityConfig& gravity, const Pose& X_BH);

/// The pull of that weight on the handle, −∇U by differences.
Wrench pull_of_weight(std::string_view driver, const GravityConfig& gravity, const Pose& X_BH);

/// A bare arm with these masses behind its bytes, which somebody holds at a place until he lets go.
/// Its mass, damping and friction at the handle are those of the driver's row.
class WeighedArm {
 public:
  WeighedArm(const DriverRow& row, const GravityConfig& gravity, const Vec3& place_B);

  DriverBench& device() { return *bench_; }
  /// On the handle, where it is.
  const Wrench& pull_B() const { return pull_B_; }

  bool is_held = true;
  Vec3 place_B;       // where it is held
  double stand = -1;  // height of what it lies on, along up [m]
  bool has_stand = false;

 private:
  Wrench load(const HandPlant& plant);

  std::string_view driver_;
  GravityConfig gravity_;
  Vec3 up_B_;
  Pose pulled_at_{{1e9, 0, 0}, {}};
  Wrench pull_B_;
  std::unique_ptr<DriverBench> bench_;
};

}  // namespace haptic::test
