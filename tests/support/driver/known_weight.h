// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string_view>

#include "proto/config/device_config.h"
#include "proto/math/pose.h"

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

}  // namespace haptic::test
