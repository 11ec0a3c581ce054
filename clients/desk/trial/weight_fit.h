// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "proto/config/device_config.h"

namespace haptic {

/// The wrench that would hold the arm up, where it is, if it had these masses (Device::holding).
using HoldingOf = std::function<Wrench(const GravityConfig& gravity)>;

/// A place that an arm was weighed at.
struct WeighedPlace {
  Vec3 weight_B;              // force that held it up: the mean of rising and sinking [N]
  double friction = 0;        // half their difference, along up [N]
  std::vector<Vec3> columns;  // by holding_columns, there [N]
};

/// Masses that hold an arm up as it was weighed.
struct WeightFit {
  GravityConfig gravity;
  double residual = 0, largest_residual = 0;  // of the force at a place: root mean square, most [N]
  double least_weight = 0, most_weight = 0;   // of the places [N]
  double friction = 0, most_friction = 0;     // mean and most [N]
};

/// Returns the forces that hold up one kilogram [N]: first at the handle, then for each of
/// `n_links` links at 100 mm along it, and what 100 mm along y and along z add to one in its
/// origin.
std::vector<Vec3> holding_columns(const HoldingOf& holding, const Vec3& down_B, size_t n_links);

/// Least squares over all places, at least one: force = columns · unknowns. Where the places do not
/// tell some unknowns apart, as forearm and handle, the smallest ones are taken: a table that holds
/// up the arm, not what it is made of. A link whose centre would lie half a metre away or more has
/// none beside its line.
WeightFit fit_weight(const std::vector<WeighedPlace>& places, const Vec3& down_B, size_t n_links);

/// The masses as a block of a session file, by the names of the bodies (DeviceRow::links).
std::string gravity_block(const GravityConfig& gravity, std::span<const std::string_view> names);

}  // namespace haptic
