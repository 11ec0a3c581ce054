// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/mesh/judge.h"

#include <algorithm>
#include <cmath>

#include "clients/lab/support/measurement.h"
#include "clients/lab/support/median.h"

namespace haptic {
namespace {

constexpr double kJamForce = 0.1;    // [N] beyond the exact force
constexpr double kJamShare = 0.1;    // of the tool's motion in a tick
constexpr double kLeastWay = 1e-6;   // [m]; a smaller motion of the tool is rest, not a jam
constexpr double kLostDepth = 1e-5;  // [m]; see "lost"
// [m]; a proxy leaves a saddle vertex only for a way of more than 16 of its own distances from the
// surface (point_proxy.h), 1.6 µm
constexpr double kLeaveLag = 2e-6;
constexpr double kLeastDescent = 1e-6;  // [N]; see "not a local minimum"

}  // namespace

void EvalJudge::add(const ServoFrame& frame, uint32_t contact_flags, const OracleAnswer& truth,
                    const JudgedPlace& place) {
  const Vec3 tool = frame.X_WT.p, proxy = frame.X_WP.p;
  const Vec3 force = frame.F_coupling_W.f, exact = stiffness_ * (truth.proxy_O - tool);
  const double error = norm(force - exact);
  const double ripple = found_.ticks > 0 ? norm((force - last_force_) - (exact - last_exact_)) : 0;
  if (!is_finite(force) || !is_finite(frame.F_device_B) || !is_finite(frame.X_WG))
    ++found_.not_finite;

  const double depth = norm(truth.proxy_O - tool);
  found_.touching += depth > 0;
  found_.lost += depth > kLostDepth && norm(force) == 0;
  const double way = norm(tool - last_tool_);
  const bool stays =
      found_.ticks > 0 && way > kLeastWay && norm(proxy - last_proxy_) < kJamShare * way;
  const bool jams = stays && norm(force) > norm(exact) + kJamForce;
  jam_length_ = jams ? jam_length_ + 1 : 0;
  found_.jammed += jams;
  found_.longest_jam = std::max(found_.longest_jam, jam_length_);
  found_.limits += (contact_flags & (kContactIterationLimit | kContactTruncated)) != 0 ||
                   (frame.flags & kServoSolverLimit) != 0;
  found_.oracle_open += !truth.converged;

  squared_error_ += error * error;
  squared_ripple_ += ripple * ripple;
  const bool is_leaving = truth.has_left && norm(proxy - truth.proxy_O) <= kLeaveLag;
  found_.leaving += is_leaving;
  if (is_leaving) {
    found_.worst_leaving = std::max(found_.worst_leaving, error);
  } else if (!(error <= found_.worst_error)) {
    found_.worst_error = error;
    found_.worst_tick = frame.tick;
  }
  found_.worst_ripple = std::max(found_.worst_ripple, ripple);
  found_.deepest_behind = std::max(found_.deepest_behind, place.behind.depth);
  const bool rests = stiffness_ * place.descent <= kLeastDescent;
  found_.not_minimal += !rests;
  stuck_length_ = stays && !rests ? stuck_length_ + 1 : 0;
  found_.longest_stuck = std::max(found_.longest_stuck, stuck_length_);
  found_.largest_descent = std::max(found_.largest_descent, place.descent);
  found_.deepest_tool = std::max(found_.deepest_tool, depth);
  found_.largest_force = std::max(found_.largest_force, norm(force));
  found_.largest_held = std::max(found_.largest_held, norm(frame.F_device_B.f));
  trace_.t.push_back(static_cast<double>(found_.ticks) * 1e-3);
  trace_.force.push_back(norm(force));
  trace_.exact.push_back(norm(exact));
  trace_.error.push_back(error);
  trace_.ripple.push_back(ripple);
  last_tool_ = tool, last_proxy_ = proxy, last_force_ = force, last_exact_ = exact;
  ++found_.ticks;
}

double EvalJudge::rms_error() const {
  return found_.ticks > 0 ? std::sqrt(squared_error_ / static_cast<double>(found_.ticks)) : 0;
}

void EvalJudge::add_rows(const std::string& name, const EvalGoals& goals, const Rows& all) const {
  const auto no_jams = goal_if(goals.follows_oracle, 0);
  const double n = static_cast<double>(std::max<uint64_t>(found_.ticks, 1));
  all.of(name).add(
      {{"ticks", found_.ticks},
       {"ticks in contact", found_.touching},
       {"force error, rms", rms_error(), "N", at_most(goals.rms_force_error)},
       {"force error, p99", percentile(trace_.error, 99), "N"},
       {"force error, max", found_.worst_error, "N", at_most(goals.max_force_error)},
       {"ticks in which the exact one leaves a saddle vertex", found_.leaving},
       {"force error in these, max", found_.worst_leaving, "N"},
       {"ripple, rms", std::sqrt(squared_ripple_ / n), "N"},
       {"ripple, max", found_.worst_ripple, "N", at_most(goals.max_ripple)},
       {"jammed ticks", found_.jammed, "", at_most(no_jams)},
       {"longest jam, ticks", found_.longest_jam},
       {"longest stuck away from rest, ticks", found_.longest_stuck},
       {"ticks fallen through", found_.lost, "", at_most(no_jams)},
       {"verified proxy behind the surface, max", found_.deepest_behind, "m", at_most(no_jams)},
       {"ticks not in a local minimum", found_.not_minimal, "", at_most(goal_if(goals.rests, 0))},
       {"force a step on towards the tool would change, max", stiffness_ * found_.largest_descent,
        "N"},
       {"tool behind the surface, max", found_.deepest_tool, "m"},
       {"force, max", found_.largest_force, "N"},
       {"force held by the device, max", found_.largest_held, "N", at_most(goals.force_limit)},
       {"ticks not finite", found_.not_finite, "", kMustBeZero},
       {"ticks at a solver's limit", found_.limits},
       {"ticks without an answer of the oracle", found_.oracle_open}});
}

}  // namespace haptic
