// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <catch2/catch.hpp>

#include "proto/math/pose.h"
#include "tests/support/tolerance.h"

template <>
struct Catch::StringMaker<haptic::Vec3> {
  static std::string convert(const haptic::Vec3& a) {
    Catch::ReusableStringStream text;
    text << "(" << a.x << ", " << a.y << ", " << a.z << ")";
    return text.str();
  }
};

namespace haptic::test {

inline constexpr double kAlgebra = 1e-12;  // a few roundings of numbers near one

/// Catch2 matcher: a vector within an absolute distance (scaled by HAPTIC_TOL_SCALE) of another.
class IsNear : public Catch::MatcherBase<Vec3> {
 public:
  IsNear(const Vec3& expected, double tolerance)
      : expected_(expected), tolerance_(tol(tolerance)) {}
  bool match(const Vec3& actual) const override { return norm(actual - expected_) <= tolerance_; }
  std::string describe() const override {
    return "is within " + Catch::StringMaker<double>::convert(tolerance_) + " of " +
           Catch::StringMaker<Vec3>::convert(expected_);
  }

 private:
  Vec3 expected_;
  double tolerance_;
};

}  // namespace haptic::test
