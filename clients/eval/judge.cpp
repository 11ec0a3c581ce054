// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/eval/judge.h"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr double kJamForce = 0.1;       // [N] beyond the exact force
constexpr double kJamShare = 0.1;       // of the tool's motion in a tick
constexpr double kLeastWay = 1e-6;      // [m]; a smaller motion of the tool is rest, not a jam
constexpr double kLostDepth = 1e-5;     // [m]; see "lost"
constexpr double kLeastDescent = 1e-6;  // [N]; see "not a local minimum"

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto rank = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<size_t>(rank)];
}

}  // namespace

void EvalJudge::add(const ServoFrame& frame, uint32_t contact_flags, const OracleAnswer& truth,
                    const JudgedPlace& place) {
  const Vec3 tool = frame.X_WT.p, proxy = frame.X_WP.p;
  const Vec3 force = frame.F_coupling_W.f, exact = stiffness_ * (truth.proxy_O - tool);
  const double error = norm(force - exact);
  const double ripple = ticks_ > 0 ? norm((force - last_force_) - (exact - last_exact_)) : 0;
  if (!is_finite(force) || !is_finite(frame.F_device_B) || !is_finite(frame.X_WG)) ++not_finite_;

  const double depth = norm(truth.proxy_O - tool);
  touching_ += depth > 0;
  lost_ += depth > kLostDepth && norm(force) == 0;
  const double way = norm(tool - last_tool_);
  const bool stays = ticks_ > 0 && way > kLeastWay && norm(proxy - last_proxy_) < kJamShare * way;
  const bool jams = stays && norm(force) > norm(exact) + kJamForce;
  jam_length_ = jams ? jam_length_ + 1 : 0;
  jammed_ += jams;
  longest_jam_ = std::max(longest_jam_, jam_length_);
  limits_ += (contact_flags & (kContactIterationLimit | kContactTruncated)) != 0 ||
             (frame.flags & kServoSolverLimit) != 0;
  oracle_open_ += !truth.converged;

  squared_error_ += error * error;
  squared_ripple_ += ripple * ripple;
  if (!(error <= worst_error_)) worst_error_ = error, worst_tick_ = frame.tick;
  worst_ripple_ = std::max(worst_ripple_, ripple);
  deepest_behind_ = std::max(deepest_behind_, place.behind.depth);
  const bool rests = stiffness_ * place.descent <= kLeastDescent;
  not_minimal_ += !rests;
  stuck_length_ = stays && !rests ? stuck_length_ + 1 : 0;
  longest_stuck_ = std::max(longest_stuck_, stuck_length_);
  largest_descent_ = std::max(largest_descent_, place.descent);
  deepest_tool_ = std::max(deepest_tool_, depth);
  largest_force_ = std::max(largest_force_, norm(force));
  largest_held_ = std::max(largest_held_, norm(frame.F_device_B.f));
  trace_.t.push_back(static_cast<double>(ticks_) * 1e-3);
  trace_.force.push_back(norm(force));
  trace_.exact.push_back(norm(exact));
  trace_.error.push_back(error);
  trace_.ripple.push_back(ripple);
  last_tool_ = tool, last_proxy_ = proxy, last_force_ = force, last_exact_ = exact;
  ++ticks_;
}

double EvalJudge::rms_error() const {
  return ticks_ > 0 ? std::sqrt(squared_error_ / static_cast<double>(ticks_)) : 0;
}

std::vector<Row> EvalJudge::rows(const std::string& name, const EvalGoals& goals) const {
  Rows rows(name);
  const auto no_jams = goal_if(goals.follows_oracle, 0);
  const double n = static_cast<double>(std::max<uint64_t>(ticks_, 1));
  rows.add("ticks", ticks_);
  rows.add("ticks in contact", touching_);
  rows.at_most("force error, rms", rms_error(), "N", goals.rms_force_error);
  rows.add("force error, p99", percentile(trace_.error, 0.99), "N");
  rows.at_most("force error, max", worst_error_, "N", goals.max_force_error);
  rows.add("ripple, rms", std::sqrt(squared_ripple_ / n), "N");
  rows.at_most("ripple, max", worst_ripple_, "N", goals.max_ripple);
  rows.at_most("jammed ticks", jammed_, "", no_jams);
  rows.add("longest jam, ticks", longest_jam_);
  rows.add("longest stuck away from rest, ticks", longest_stuck_);
  rows.at_most("ticks fallen through", lost_, "", no_jams);
  rows.at_most("verified proxy behind the surface, max", deepest_behind_, "m", no_jams);
  rows.at_most("ticks not in a local minimum", not_minimal_, "", goal_if(goals.rests, 0));
  rows.add("force a step on towards the tool would change, max", largest_descent(), "N");
  rows.add("tool behind the surface, max", deepest_tool_, "m");
  rows.add("force, max", largest_force_, "N");
  rows.at_most("force held by the device, max", largest_held_, "N", goals.force_limit);
  rows.none("ticks not finite", not_finite_);
  rows.add("ticks at a solver's limit", limits_);
  rows.add("ticks without an answer of the oracle", oracle_open_);
  return rows.rows();
}

}  // namespace haptic
