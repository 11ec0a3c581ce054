// SPDX-License-Identifier: Apache-2.0
#include "proto/config/quantity.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <ranges>
#include <string>

#include "proto/math/units.h"
#include "proto/os/message.h"
#include "proto/os/text.h"

namespace haptic {
namespace {

// [SI units]: larger values have no use, and products of a few are still finite
constexpr double kMost = 1e12;
constexpr double kMostMemory = 1e15;  // [bytes]; exact in a double

struct Kind {
  Dimension dimension;
  std::string_view name, example;
  double most = kMost;  // in SI units, either sign
};

constexpr std::array<Kind, 22> kKinds{{
    {Dimension::kLength, "a length", "100 mm", kMostLength},
    {Dimension::kMass, "a mass", "100 g"},
    {Dimension::kTime, "a time", "0.5 s"},
    {Dimension::kFrequency, "a rate", "1 kHz"},
    {Dimension::kSpeed, "a speed", "2 m/s"},
    {Dimension::kAngularSpeed, "an angular velocity", "20 rad/s"},
    {Dimension::kAcceleration, "an acceleration", "9.81 m/s²"},
    {Dimension::kAngle, "an angle", "90 deg"},
    {Dimension::kForce, "a force", "8 N"},
    {Dimension::kForceRate, "a rise of force", "2000 N/s"},
    {Dimension::kPower, "a power", "0.2 W"},
    {Dimension::kTorque, "a torque", "0.1 N·m"},
    {Dimension::kTorqueRate, "a rise of torque", "30 N·m/s"},
    {Dimension::kStiffness, "a stiffness", "800 N/m"},
    {Dimension::kDamping, "a damping", "1 N·s/m"},
    {Dimension::kRotationalStiffness, "a rotational stiffness", "2 N·m/rad"},
    {Dimension::kRotationalDamping, "a rotational damping", "0.01 N·m·s/rad"},
    {Dimension::kInertia, "a moment of inertia", "1e-4 kg·m²"},
    {Dimension::kDensity, "a density", "1 g/cm³"},
    {Dimension::kCurrent, "a current", "3 A"},
    {Dimension::kTorqueConstant, "a torque constant", "0.0259 N·m/A"},
    {Dimension::kMemory, "an amount of memory", "4 GiB", kMostMemory},
}};

struct Unit {
  std::string_view name;  // without spaces and multiplication signs
  Dimension dimension;
  double factor;  // to SI
};

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
    {"h", Dimension::kTime, 3600},
    {"Hz", Dimension::kFrequency, 1},
    {"kHz", Dimension::kFrequency, 1e3},
    {"m/s", Dimension::kSpeed, 1},
    {"mm/s", Dimension::kSpeed, 1e-3},
    {"rad/s", Dimension::kAngularSpeed, 1},
    {"deg/s", Dimension::kAngularSpeed, kDegree},
    {"m/s²", Dimension::kAcceleration, 1},
    {"m/s2", Dimension::kAcceleration, 1},
    {"rad", Dimension::kAngle, 1},
    {"mrad", Dimension::kAngle, 1e-3},
    {"deg", Dimension::kAngle, kDegree},
    {"°", Dimension::kAngle, kDegree},
    {"N", Dimension::kForce, 1},
    {"mN", Dimension::kForce, 1e-3},
    {"kN", Dimension::kForce, 1e3},
    {"N/s", Dimension::kForceRate, 1},
    {"N/ms", Dimension::kForceRate, 1e3},
    {"W", Dimension::kPower, 1},
    {"mW", Dimension::kPower, 1e-3},
    {"Nm", Dimension::kTorque, 1},
    {"mNm", Dimension::kTorque, 1e-3},
    {"Nmm", Dimension::kTorque, 1e-3},
    {"Nm/s", Dimension::kTorqueRate, 1},
    {"mNm/s", Dimension::kTorqueRate, 1e-3},
    {"Nm/ms", Dimension::kTorqueRate, 1e3},
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
    {"Nm/A", Dimension::kTorqueConstant, 1},
    {"mNm/A", Dimension::kTorqueConstant, 1e-3},
    {"B", Dimension::kMemory, 1},
    {"kB", Dimension::kMemory, 1e3},
    {"MB", Dimension::kMemory, 1e6},
    {"GB", Dimension::kMemory, 1e9},
    {"KiB", Dimension::kMemory, 1024.0},
    {"MiB", Dimension::kMemory, 1048576.0},
    {"GiB", Dimension::kMemory, 1073741824.0},
});

const Kind& kind_of_dimension(Dimension dimension) {
  return *std::find_if(kKinds.begin(), kKinds.end(),
                       [&](const Kind& kind) { return kind.dimension == dimension; });
}

/// The unit whose factor is 1.
std::string_view si_unit(Dimension dimension) {
  return std::find_if(
             kUnits.begin(), kUnits.end(),
             [&](const Unit& unit) { return unit.dimension == dimension && unit.factor == 1; })
      ->name;
}

/// Problem of a finite value, with `written` as its text; empty: none. `unit` is appended to each
/// bound.
std::string range_problem(double value, const Range& range, const std::string& unit,
                          const std::string& written) {
  if (value > range.min || (value == range.min && !range.open)) {
    if (value <= range.max) return "";
  }
  const std::string min = number_text(range.min);
  if (std::isfinite(range.max)) {
    return "is out of range (" + written + "); it must lie between " + min + unit + " and " +
           number_text(range.max) + unit;
  }
  return (range.open ? "must be greater than " : "must not be less than ") + min + " (" + written +
         "); write a larger value";
}

struct Number {
  double value = 0;
  std::string_view rest;   // text behind the number
  std::string_view wrong;  // problem; empty: none
};

/// The number at the beginning of a text.
Number read_number(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  Number number;
  const char* const end_of_text = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), end_of_text, number.value);
  number.rest = text.substr(static_cast<size_t>(end - text.data()));
  if (error == std::errc::result_out_of_range) {
    number.wrong = "is too large or too small";
  } else if (error != std::errc()) {
    number.wrong = "does not begin with a number";
  } else if (!std::isfinite(number.value)) {
    number.wrong = "is not a finite number";
  } else if (number.rest.starts_with(',')) {
    number.wrong = "has a comma; the decimal sign is a point, as in 8.5";
  }
  return number;
}

/// The value in SI units of a parsed number; only its unit can still be wrong.
double with_unit(const Number& number, Dimension dimension, std::string_view bare_unit,
                 const std::string& quoted) {
  const auto fail = [&](const std::string& what) {
    throw QuantityError(quoted + " " + what + "; " + how_to_write(dimension));
  };
  // without spaces and multiplication signs
  std::string unit = replaced(number.rest, {{"·", ""}, {"*", ""}, {" ", ""}});
  if (unit.empty()) unit = bare_unit;
  if (unit.empty()) fail("needs a unit");
  const auto at =
      std::find_if(kUnits.begin(), kUnits.end(), [&](const Unit& u) { return u.name == unit; });
  if (at == kUnits.end()) fail("has an unknown unit");
  if (at->dimension != dimension) {
    fail("is " + std::string(kind_of_dimension(at->dimension).name) + ", not " +
         std::string(kind_of_dimension(dimension).name));
  }
  return number.value * at->factor;
}

std::string in_quotes(std::string_view text) {
  return "\"" + shown(text) + "\"";
}

}  // namespace

std::string_view example_of(Dimension dimension) {
  return kind_of_dimension(dimension).example;
}

std::string_view name_of(Dimension dimension) {
  const std::string_view name = kind_of_dimension(dimension).name;
  return name.substr(name.find(' ') + 1);
}

std::string how_to_write(Dimension dimension) {
  return "write for example \"" + std::string(example_of(dimension)) + "\"; known units: " +
         joined(kUnits | std::views::filter(
                             [&](const Unit& unit) { return unit.dimension == dimension; }),
                &Unit::name);
}

std::string number_text(double value) {
  std::array<char, 32> text;
  return std::string(text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr);
}

std::string quantity_text(double value, Dimension dimension) {
  return number_text(value) + " " + std::string(si_unit(dimension));
}

double parse_quantity(std::string_view text, Dimension dimension, const Range& range,
                      std::string_view bare_unit) {
  const std::string quoted = in_quotes(text);
  const Number number = read_number(text);
  if (!number.wrong.empty()) {
    throw QuantityError(quoted + " " + std::string(number.wrong) + "; " + how_to_write(dimension));
  }
  const double value = with_unit(number, dimension, bare_unit, quoted);
  const double most = kind_of_dimension(dimension).most;
  if (!(std::fabs(value) <= most)) {
    throw QuantityError(quoted + " is too large; the most is " + quantity_text(most, dimension) +
                        "; " + how_to_write(dimension));
  }
  const std::string wrong =
      range_problem(value, range, " " + std::string(si_unit(dimension)), quoted);
  if (!wrong.empty()) throw QuantityError(wrong);
  return value;
}

std::string number_problem(double value, const Range& range) {
  if (!std::isfinite(value)) return "is not a finite number; write a number";
  const std::string written = number_text(value);
  if (std::fabs(value) > kMost)
    return "is too large (" + written + "); the most is " + number_text(kMost);
  return range_problem(value, range, "", written);
}

double parse_number(std::string_view text, const Range& range) {
  const std::string quoted = in_quotes(text);
  const Number number = read_number(text);
  if (!number.wrong.empty()) {
    throw QuantityError(quoted + " " + std::string(number.wrong) + "; write for example 0.5");
  }
  if (number.rest.find_first_not_of(' ') != std::string_view::npos) {
    throw QuantityError(quoted + " is not a number; write it without a unit, for example 0.5");
  }
  const std::string wrong = number_problem(number.value, range);
  if (!wrong.empty()) throw QuantityError(wrong);
  return number.value;
}

}  // namespace haptic
