// SPDX-License-Identifier: Apache-2.0
#include "proto/quantity.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <string>

namespace haptic {
namespace {

struct Kind {
  Dimension dimension;
  std::string_view name, example;
};

constexpr std::array<Kind, 17> kKinds{{
    {Dimension::kLength, "a length", "100 mm"},
    {Dimension::kMass, "a mass", "100 g"},
    {Dimension::kTime, "a time", "0.5 s"},
    {Dimension::kFrequency, "a rate", "1 kHz"},
    {Dimension::kSpeed, "a speed", "2 m/s"},
    {Dimension::kAngle, "an angle", "90 deg"},
    {Dimension::kForce, "a force", "8 N"},
    {Dimension::kForceRate, "a rise of force", "2000 N/s"},
    {Dimension::kTorque, "a torque", "0.1 N·m"},
    {Dimension::kStiffness, "a stiffness", "800 N/m"},
    {Dimension::kDamping, "a damping", "1 N·s/m"},
    {Dimension::kRotationalStiffness, "a rotational stiffness", "2 N·m/rad"},
    {Dimension::kRotationalDamping, "a rotational damping", "0.01 N·m·s/rad"},
    {Dimension::kInertia, "a moment of inertia", "1e-4 kg·m²"},
    {Dimension::kDensity, "a density", "1 g/cm³"},
    {Dimension::kCurrent, "a current", "3 A"},
    {Dimension::kMemory, "an amount of memory", "4 GiB"},
}};

struct Unit {
  std::string_view name;  // without spaces and multiplication signs
  Dimension dimension;
  double factor;  // to SI
};

constexpr double kDegree = std::numbers::pi / 180;

constexpr std::array kUnits = std::to_array<Unit>({
    {"m", Dimension::kLength, 1},
    {"cm", Dimension::kLength, 1e-2},
    {"mm", Dimension::kLength, 1e-3},
    {"um", Dimension::kLength, 1e-6},
    {"µm", Dimension::kLength, 1e-6},
    {"in", Dimension::kLength, 0.0254},
    {"kg", Dimension::kMass, 1},
    {"g", Dimension::kMass, 1e-3},
    {"s", Dimension::kTime, 1},
    {"ms", Dimension::kTime, 1e-3},
    {"us", Dimension::kTime, 1e-6},
    {"µs", Dimension::kTime, 1e-6},
    {"min", Dimension::kTime, 60},
    {"Hz", Dimension::kFrequency, 1},
    {"kHz", Dimension::kFrequency, 1e3},
    {"m/s", Dimension::kSpeed, 1},
    {"mm/s", Dimension::kSpeed, 1e-3},
    {"rad", Dimension::kAngle, 1},
    {"mrad", Dimension::kAngle, 1e-3},
    {"deg", Dimension::kAngle, kDegree},
    {"°", Dimension::kAngle, kDegree},
    {"N", Dimension::kForce, 1},
    {"mN", Dimension::kForce, 1e-3},
    {"kN", Dimension::kForce, 1e3},
    {"N/s", Dimension::kForceRate, 1},
    {"N/ms", Dimension::kForceRate, 1e3},
    {"Nm", Dimension::kTorque, 1},
    {"mNm", Dimension::kTorque, 1e-3},
    {"Nmm", Dimension::kTorque, 1e-3},
    {"N/m", Dimension::kStiffness, 1},
    {"N/mm", Dimension::kStiffness, 1e3},
    {"kN/m", Dimension::kStiffness, 1e3},
    {"Ns/m", Dimension::kDamping, 1},
    {"Ns/mm", Dimension::kDamping, 1e3},
    {"Nm/rad", Dimension::kRotationalStiffness, 1},
    {"mNm/rad", Dimension::kRotationalStiffness, 1e-3},
    {"Nm/deg", Dimension::kRotationalStiffness, 1 / kDegree},
    {"Nms/rad", Dimension::kRotationalDamping, 1},
    {"mNms/rad", Dimension::kRotationalDamping, 1e-3},
    {"kgm²", Dimension::kInertia, 1},
    {"kgm2", Dimension::kInertia, 1},
    {"gcm²", Dimension::kInertia, 1e-7},
    {"gcm2", Dimension::kInertia, 1e-7},
    {"kg/m³", Dimension::kDensity, 1},
    {"kg/m3", Dimension::kDensity, 1},
    {"g/cm³", Dimension::kDensity, 1e3},
    {"g/cm3", Dimension::kDensity, 1e3},
    {"A", Dimension::kCurrent, 1},
    {"mA", Dimension::kCurrent, 1e-3},
    {"B", Dimension::kMemory, 1},
    {"kB", Dimension::kMemory, 1e3},
    {"MB", Dimension::kMemory, 1e6},
    {"GB", Dimension::kMemory, 1e9},
    {"KiB", Dimension::kMemory, 1024.0},
    {"MiB", Dimension::kMemory, 1048576.0},
    {"GiB", Dimension::kMemory, 1073741824.0},
});

const Kind& kind_of(Dimension dimension) {
  return *std::find_if(kKinds.begin(), kKinds.end(),
                       [&](const Kind& kind) { return kind.dimension == dimension; });
}

/// The unit without spaces and signs of multiplication.
std::string compact(std::string_view unit) {
  std::string out;
  constexpr std::string_view kDot = "·";
  while (!unit.empty()) {
    if (unit.starts_with(kDot)) {
      unit.remove_prefix(kDot.size());
      continue;
    }
    if (unit.front() != ' ' && unit.front() != '*') out += unit.front();
    unit.remove_prefix(1);
  }
  return out;
}

[[noreturn]] void fail(const std::string& what, Dimension dimension) {
  throw QuantityError(what + "; write for example \"" + std::string(example_of(dimension)) + "\"");
}

}  // namespace

std::string_view example_of(Dimension dimension) {
  return kind_of(dimension).example;
}

double parse_quantity(std::string_view text, Dimension dimension) {
  const std::string quoted = "\"" + std::string(text) + "\"";
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc::result_out_of_range)
    fail(quoted + " is too large or too small", dimension);
  if (error != std::errc()) fail(quoted + " does not begin with a number", dimension);
  if (!std::isfinite(value)) fail(quoted + " is not a finite number", dimension);

  const std::string unit = compact(text.substr(static_cast<size_t>(end - text.data())));
  if (unit.empty()) fail(quoted + " needs a unit", dimension);
  const auto at =
      std::find_if(kUnits.begin(), kUnits.end(), [&](const Unit& u) { return u.name == unit; });
  if (at == kUnits.end()) fail(quoted + " has an unknown unit", dimension);
  if (at->dimension != dimension) {
    fail(quoted + " is " + std::string(kind_of(at->dimension).name) + ", not " +
             std::string(kind_of(dimension).name),
         dimension);
  }
  return value * at->factor;
}

}  // namespace haptic
