// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "clients/report/report.h"
#include "proto/wire/wire.h"

namespace haptic {

/// Measures |f_t| / |f_n| on a plane of known normal in every tick in which the proxy slides: it
/// has moved along the plane since the last tick and is pressed in both.
class FrictionJudge {
 public:
  FrictionJudge(double ratio, const Vec3& normal_W) : ratio_(ratio), normal_W_(normal_W) {}

  void add(const ServoFrame& frame);

  uint64_t sliding() const { return sliding_; }
  /// Largest | |f_t| / (μ |f_n|) − 1 | while sliding.
  double worst() const { return worst_; }

  void add_rows(const std::string& name, const Rows& all) const;

 private:
  double ratio_;
  Vec3 normal_W_, last_proxy_W_;
  bool pressed_ = false;
  uint64_t sliding_ = 0;
  double worst_ = 0, sum_ = 0;
};

}  // namespace haptic
