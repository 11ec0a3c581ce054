// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "clients/eval/oracle/oracle.h"
#include "clients/eval/oracle/place.h"
#include "clients/report/report.h"
#include "proto/wire/wire.h"

namespace haptic {

/// What a run may miss the oracle by.
struct EvalGoals {
  double max_force_error = 0;  // [N]; 0: not judged
  double rms_force_error = 0;  // [N]; 0: not judged
  double max_ripple = 0;       // [N]; 0: not judged
  double force_limit = 0;      // of the device [N]
  bool follows_oracle = true;  // jams and lost ticks are judged too
  bool rests = false;          // in a local minimum of |x − tool|, tick by tick
};

/// Where the proxies of one tick are, by every facet near them.
struct JudgedPlace {
  BehindSurface behind;  // the verified one
  double descent = 0;    // of the felt one (free_descent) [m]
};

/// Compares a run, tick by tick, with the exact god-object. Forces are those of the coupling, k
/// times the way from the tool to the proxy, before safety: what a renderer is to be judged by.
///
/// - force error: |F − F*|, F* = k (proxy* − tool) of the oracle at the same tick
/// - ripple: |ΔF − ΔF*| from tick to tick
/// - jammed: the force is more than kJamForce beyond the oracle's while the proxy moves less than a
///   tenth of what the tool does: it stays, the tool slides on, the force runs up
/// - stuck: the proxy stays as above though it is not in a local minimum, whatever the oracle says
/// - lost: the oracle is deeper than kLostDepth and there is no force: fallen through
/// - behind: depth of the verified proxy behind the surface, or nearer to it than its radius
/// - not a local minimum: the felt proxy could still go so far towards the tool, without entering
///   any facet that it touches, that the force would change by more than kLeastDescent
class EvalJudge {
 public:
  explicit EvalJudge(double stiffness) : stiffness_(stiffness) {}

  void add(const ServoFrame& frame, uint32_t contact_flags, const OracleAnswer& truth,
           const JudgedPlace& place);

  /// Notes that the tool overlapped the object at the start: the renderer and the exact solution
  /// then follow different seeds, and their forces cannot be compared.
  void begin(bool overlaps) { began_overlapping_ = overlaps; }
  bool began_overlapping() const { return began_overlapping_; }

  std::vector<Row> rows(const std::string& name, const EvalGoals& goals) const;

  /// Largest |F − F*| so far, and its tick.
  double worst_error() const { return worst_error_; }
  uint64_t worst_tick() const { return worst_tick_; }

  uint64_t ticks() const { return ticks_; }
  uint64_t touching() const { return touching_; }
  uint64_t jammed() const { return jammed_; }
  uint64_t lost() const { return lost_; }
  double rms_error() const;
  double worst_ripple() const { return worst_ripple_; }
  double deepest_behind() const { return deepest_behind_; }
  uint64_t not_finite() const { return not_finite_; }
  double largest_held() const { return largest_held_; }
  uint64_t longest_stuck() const { return longest_stuck_; }  // [ticks]
  uint64_t not_minimal() const { return not_minimal_; }
  double largest_descent() const { return stiffness_ * largest_descent_; }  // [N]

  /// For the plot: one value a tick.
  struct Trace {
    std::vector<double> t, force, exact, error, ripple;
  };
  const Trace& trace() const { return trace_; }

 private:
  double stiffness_;
  bool began_overlapping_ = false;
  Trace trace_;
  uint64_t ticks_ = 0, touching_ = 0, jammed_ = 0, lost_ = 0, stuck_length_ = 0, longest_stuck_ = 0,
           not_finite_ = 0, not_minimal_ = 0;
  uint64_t jam_length_ = 0, longest_jam_ = 0, limits_ = 0, oracle_open_ = 0, worst_tick_ = 0;
  double squared_error_ = 0, worst_error_ = 0, squared_ripple_ = 0, worst_ripple_ = 0;
  double deepest_behind_ = 0, deepest_tool_ = 0, largest_force_ = 0, largest_held_ = 0,
         largest_descent_ = 0;
  Vec3 last_tool_, last_proxy_, last_force_, last_exact_;
};

}  // namespace haptic
