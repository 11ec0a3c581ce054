// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string_view>

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
struct QuantityError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The value in SI units of a number with its unit: "800 N/m", "2 mm", "1 kHz", "90 deg", "4 GiB".
/// A product may be written "N·s/m", "N*s/m", "N s/m" or "Ns/m". Throws QuantityError: no number,
/// not finite, no unit, an unknown unit, or the unit of another kind.
double parse_quantity(std::string_view text, Dimension dimension);

/// A value of this kind as a person would write it, for messages: "800 N/m".
std::string_view example_of(Dimension dimension);

}  // namespace haptic
