// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "clients/bench/work/ccd_queries.h"

namespace haptic {

/// Redon's method (Redon, Kheddar, Coquillart 2002) for corners that go straight: the volume of the
/// four corners by interval arithmetic over a stretch of time; where it may be zero the stretch is
/// halved, the earlier half first, until it is shorter than `shortest`; then the place must be
/// within both features, by intervals too. Time of the first such stretch; also where more than
/// `budget` stretches were looked at.
std::optional<double> meeting_by_intervals(const CcdQuery& query, double shortest, uint32_t budget);

}  // namespace haptic
