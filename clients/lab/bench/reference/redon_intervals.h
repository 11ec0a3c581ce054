// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "clients/lab/bench/workloads/ccd_queries.h"

namespace haptic {

/// The method of Redon, Kheddar & Coquillart 2002 for corners that move linearly: bounds the volume
/// of the four corners by interval arithmetic over a time interval. If it may be zero, the interval
/// is bisected, the earlier half first, until it is shorter than `shortest`; the contact must then
/// be within both features, also by intervals. Returns the start of the first such interval, or of
/// the current one after `budget` intervals.
std::optional<double> meeting_by_intervals(const CcdQuery& query, double shortest, uint32_t budget);

}  // namespace haptic
