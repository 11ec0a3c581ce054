// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <string>
#include <string_view>

#include "proto/os/message.h"

namespace haptic {

/// Physical kind of a quantity.
enum class Dimension {
  kLength,               // [m]
  kMass,                 // [kg]
  kTime,                 // [s]
  kFrequency,            // [Hz]
  kSpeed,                // [m/s]
  kAngularSpeed,         // [rad/s]
  kAcceleration,         // [m/s²]
  kAngle,                // [rad]
  kForce,                // [N]
  kForceRate,            // [N/s]
  kPower,                // [W]
  kTorque,               // [N·m]
  kTorqueRate,           // [N·m/s]
  kStiffness,            // [N/m]
  kDamping,              // [N·s/m]
  kRotationalStiffness,  // [N·m/rad]
  kRotationalDamping,    // [N·m·s/rad]
  kInertia,              // [kg·m²]
  kDensity,              // [kg/m³]
  kCurrent,              // [A]
  kTorqueConstant,       // of a motor [N·m/A]
  kMemory,               // [bytes]
};

/// A text that is no quantity: the message says why and how to mend it, the caller adds the place.
struct QuantityError : InputError {
  using InputError::InputError;
};

/// Allowed values of a number, in SI units.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool open = false;  // min itself is excluded
};
inline constexpr Range kAny{};
inline constexpr Range kPositive{0, std::numeric_limits<double>::infinity(), true};
inline constexpr Range kNotNegative{0};

/// Largest length of a scene, a mesh or a coordinate [m]: there a double resolves 0.12 nm, less
/// than the 1 nm that queries treat as touching.
inline constexpr double kMostLength = 1e6;

/// Value in SI units of a number with its unit: "800 N/m", "2 mm", "1 kHz", "90 deg", "4 GiB". A
/// product may be written "N·s/m", "N*s/m", "N s/m" or "Ns/m". If `bare_unit` is given, a number
/// alone is taken in it. Throws QuantityError, which lists the known units: no number, not finite,
/// a decimal comma, no unit, an unknown unit, a unit of another kind, out of range, or larger than
/// any scene needs.
double parse_quantity(std::string_view text, Dimension dimension, const Range& range = kAny,
                      std::string_view bare_unit = "");

/// A number without unit: "0.5". Throws QuantityError.
double parse_number(std::string_view text, const Range& range = kAny);

/// Problem of a number without unit; empty: none.
std::string number_problem(double value, const Range& range);

/// Example of a value of this kind for messages: "800 N/m".
std::string_view example_of(Dimension dimension);

/// Help for messages: write for example "800 N/m"; known units: N/m, N/mm, kN/m.
std::string how_to_write(Dimension dimension);

/// Name of the kind: "length".
std::string_view name_of(Dimension dimension);

/// A number with as many digits as it needs.
std::string number_text(double value);

/// A value in SI units with its unit: "0.08 m".
std::string quantity_text(double value, Dimension dimension);

}  // namespace haptic
