// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/tree/grid_cost.h"

namespace haptic {

/// Times the parts of a first hit on this machine [s]: what kQueryCosts says of one machine for
/// all.
QueryCosts measure_query_costs();

}  // namespace haptic
