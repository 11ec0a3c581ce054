// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/solve/point/point_proxy.h"

namespace haptic {

/// Penalty force of the classical 3-DoF renderer, f = k Σ d_i n_i over the planes behind which the
/// tool is (d_i its depth), written as a proxy: proxy = tool + Σ d_i n_i. At most the first three
/// planes push. Stateless, so the force changes direction where the nearest surface changes and
/// pushes the tool out of the far side of a thin plate. Source: the penalty method as reviewed by
/// Zilles & Salisbury 1995 and Ruspini et al. 1997, who replace it.
PointProxySolution solve_direct(const ProxyQuestion& question);

}  // namespace haptic
