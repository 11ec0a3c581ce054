// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "clients/report.h"

namespace haptic {

/// The two artefacts of the penalty method, measured in lockstep and beside the god-object, which
/// has neither. Edge: the tool crosses the bisector of two faces at depth d below both, where the
/// force turns by 90° in one tick and steps by √2 k d; the god-object's force changes by no more
/// than k times the way of the tool. Plate of thickness w: nothing resists with more than k w/2,
/// beyond the middle the force helps through; the god-object goes on to resist with k times the
/// depth. Closed forms: the method's ceiling as derived from its formula; goals within 1 %.
std::vector<Row> measure_penalty_artefacts();

}  // namespace haptic
