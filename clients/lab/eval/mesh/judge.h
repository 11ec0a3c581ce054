// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "clients/lab/eval/oracle/oracle.h"
#include "clients/lab/eval/oracle/place.h"
#include "clients/report/report.h"
#include "proto/wire/wire.h"

namespace haptic {

/// Allowed differences between a run and the oracle.
struct EvalGoals {
  std::optional<double> max_force_error, rms_force_error, max_ripple;  // [N]
  std::optional<double> force_limit;                                   // of the device [N]
  bool follows_oracle = true;  // jams and lost ticks have goals
  bool rests = false;          // goal: local minimum of |x − tool| in every tick
};

/// Placement errors of the proxies in one tick, by every facet near them.
struct JudgedPlace {
  BehindSurface behind;  // of the verified proxy
  double descent = 0;    // of the servo's proxy, see free_descent() [m]
};

/// Compares a run with the exact god-object in every tick. Forces are those of the coupling before
/// the safety stages, k times the vector from tool to proxy: the output of the renderer itself.
///
/// - force error: |F − F*|, F* = k (proxy* − tool) of the oracle at the same tick. Where the oracle
///   has just left a vertex that is neither convex nor concave the proxy may lag by kLeaveLag, and
///   these ticks are counted for themselves
/// - ripple: |ΔF − ΔF*| from tick to tick
/// - jammed: the force exceeds the oracle's by more than kJamForce while the proxy moves by less
///   than a tenth of the tool's motion
/// - stuck: the proxy moves as little although it is not in a local minimum, whatever the oracle
/// - lost: the oracle is deeper than kLostDepth and there is no force: tunnelling
/// - behind: depth of the verified proxy behind the surface offset by its radius
/// - not a local minimum: the servo's proxy could still move towards the tool, without entering any
///   facet it touches, far enough to change the force by more than kLeastDescent
class EvalJudge {
 public:
  explicit EvalJudge(double stiffness) : stiffness_(stiffness) {}

  void add(const ServoFrame& frame, uint32_t contact_flags, const OracleAnswer& truth,
           const JudgedPlace& place);

  /// Records that the tool overlapped the object at the start: renderer and exact solution then
  /// start from different places, and their forces cannot be compared.
  void begin(bool overlaps) { began_overlapping_ = overlaps; }
  bool began_overlapping() const { return began_overlapping_; }

  void add_rows(const std::string& name, const EvalGoals& goals, const Rows& all) const;

  struct Found {
    uint64_t ticks = 0, touching = 0, jammed = 0, longest_jam = 0, longest_stuck = 0, lost = 0;
    uint64_t leaving = 0, not_finite = 0, not_minimal = 0, limits = 0, oracle_open = 0,
             worst_tick = 0;
    double worst_error = 0, worst_leaving = 0, worst_ripple = 0, largest_force = 0,
           largest_held = 0;                                           // [N]
    double deepest_behind = 0, deepest_tool = 0, largest_descent = 0;  // [m]
  };
  const Found& found() const { return found_; }
  double rms_error() const;

  /// For the plot: one value per tick.
  struct Trace {
    std::vector<double> t, force, exact, error, ripple;
  };
  const Trace& trace() const { return trace_; }

 private:
  double stiffness_;
  bool began_overlapping_ = false;
  Trace trace_;
  Found found_;
  uint64_t stuck_length_ = 0, jam_length_ = 0;
  double squared_error_ = 0, squared_ripple_ = 0;
  Vec3 last_tool_, last_proxy_, last_force_, last_exact_;
};

}  // namespace haptic
