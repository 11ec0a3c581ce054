// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "clients/lab/bench/workloads/ccd_queries.h"

namespace haptic {

/// FCL's elementary queries (detail::Intersect): roots of the cubic by bisection or by Newton's
/// method. Empty: no contact.
std::optional<double> meeting_by_fcl(const CcdQuery& query, bool newton);
/// True if this was built with FCL.
bool has_fcl_features();

}  // namespace haptic
