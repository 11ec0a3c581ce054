// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/mesh/friction.h"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr double kLeastSlide = 1e-6;  // motion per tick that counts as sliding [m]
constexpr double kGoal = 0.01;        // relative error of μ

}  // namespace

void FrictionJudge::add(const ServoFrame& frame) {
  const auto along = [&](const Vec3& v) { return v - dot(v, normal_W_) * normal_W_; };
  const Vec3 force_W = frame.F_coupling_W.f;
  const double pressing = dot(force_W, normal_W_);
  const bool slides =
      pressed_ && pressing > 0 && norm(along(frame.X_WP.p - last_proxy_W_)) > kLeastSlide;
  if (slides) {
    const double ratio = norm(along(force_W)) / pressing;
    ++sliding_;
    sum_ += ratio;
    worst_ = std::max(worst_, std::fabs(ratio / ratio_ - 1));
  }
  pressed_ = pressing > 0;
  last_proxy_W_ = frame.X_WP.p;
}

void FrictionJudge::add_rows(const std::string& name, const Rows& all) const {
  const double n = static_cast<double>(sliding_);
  all.of(name).add({{"ticks sliding", n},
                    {"friction ratio while sliding, mean", sliding_ > 0 ? sum_ / n : 0},
                    {"friction ratio off μ while sliding, max", worst_, "of μ",
                     given(kGoal, sliding_ > 0 && worst_ <= kGoal)}});
}

}  // namespace haptic
