// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>

#include "clients/lab/bench/workloads/ccd_queries.h"
#include "contact/query/sweep/feature_path.h"

namespace haptic {

/// Tells features that come within the tolerance [m] from features that meet: advances along the
/// path as swept_pair.h does, and from where that ends looks for the first time at which F(t, u, v)
/// = 0 may hold. Between two times F is affine in each of its three variables, so its values at the
/// corners of a box bound it. Bisects the variable that F changes most with, earliest box first,
/// until F excludes 0 or is smaller than the tolerance throughout (inclusion-based root finding in
/// three variables after Snyder 1992, Wang et al. 2021). Rounding is added term by term. A box is
/// excluded along the three axes, or along the common normal of both features half-way. Evaluates
/// at most `budget` boxes, and says that a meeting is not proven where these do not decide;
/// allocates nothing.
std::optional<SweptMeeting> meeting_by_boxes(const FeaturePath& path, double tolerance,
                                             uint32_t budget);

/// meeting_by_boxes for a query whose corners move on straight lines.
std::optional<SweptMeeting> meeting_by_boxes(const CcdQuery& query, double tolerance,
                                             uint32_t budget);

}  // namespace haptic
