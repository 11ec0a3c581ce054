// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <string>
#include <string_view>

#include "proto/os/message.h"

namespace haptic {

/// What kind of quantity a text must hold.
enum class Dimension {
  kLength,               // [m]
  kMass,                 // [kg]
  kTime,                 // [s]
  kFrequency,            // [Hz]
  kSpeed,                // [m/s]
  kAngle,                // [rad]
  kForce,                // [N]
  kForceRate,            // [N/s]
  kTorque,               // [N·m]
  kStiffness,            // [N/m]
  kDamping,              // [N·s/m]
  kRotationalStiffness,  // [N·m/rad]
  kRotationalDamping,    // [N·m·s/rad]
  kInertia,              // [kg·m²]
  kDensity,              // [kg/m³]
  kCurrent,              // [A]
  kMemory,               // [bytes]
};

/// What is wrong with the text and how to mend it, without the place: the caller knows that.
struct QuantityError : MessageError {
  using MessageError::MessageError;
};

/// Which values a number may have, in SI units.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool open = false;  // min itself is not allowed
};
inline constexpr Range kAny{};
inline constexpr Range kPositive{0, std::numeric_limits<double>::infinity(), true};
inline constexpr Range kNotNegative{0};

/// Largest length, of a scene, a mesh or a coordinate [m]: up to there a double resolves 0.12 nm,
/// which is less than the 1 nm that the queries call touching.
inline constexpr double kMostLength = 1e6;

/// The value in SI units of a number with its unit: "800 N/m", "2 mm", "1 kHz", "90 deg", "4 GiB".
/// A product may be written "N·s/m", "N*s/m", "N s/m" or "Ns/m". Where `bare_unit` is given, a
/// number alone is meant in it. Throws QuantityError with the units that are known: no number, not
/// finite, a decimal comma, no unit, an unknown unit, the unit of another kind, out of range, or
/// beyond all that a scene can hold.
double parse_quantity(std::string_view text, Dimension dimension, const Range& range = kAny,
                      std::string_view bare_unit = "");

/// A number without unit: "0.5". Throws QuantityError.
double parse_number(std::string_view text, const Range& range = kAny);

/// What is wrong with a number without unit; empty: nothing.
std::string number_problem(double value, const Range& range);

/// A value of this kind as a person would write it, for messages: "800 N/m".
std::string_view example_of(Dimension dimension);

/// How a value of this kind is written: write for example "800 N/m"; known units: N/m, N/mm, kN/m.
std::string how_to_write(Dimension dimension);

/// What the kind is called: "length".
std::string_view name_of(Dimension dimension);

/// A number as it is written, with as many digits as it needs.
std::string number_text(double value);

/// A value in SI units with its unit: "0.08 m".
std::string quantity_text(double value, Dimension dimension);

}  // namespace haptic
