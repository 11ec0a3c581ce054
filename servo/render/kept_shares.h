// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/render/render.h"

namespace haptic {

/// The share that is let through of what each placed body pushes the proxy with, 0 to 1.
using KeptShares = PerObject<double>;

/// Scales what the bodies push with, and the tool's wrench by as much: with P_i the pushes, their
/// sum P, κ_i the shares, and ρ = Σ κ_i |f_i| / Σ |f_i|,
///   F ← Σ κ_i P_i + ρ (F − P),
/// since what a proxy with mass keeps back of the pushes is scaled as these are. The pushes of a
/// surface then belong to the object that it is on.
void keep(const KeptShares& shares, const TickScene& scene, Rendered& rendered);

}  // namespace haptic
