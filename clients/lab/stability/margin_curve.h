// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "proto/config/coupling_margin.h"

namespace haptic {

struct MarginPoint {
  double frequency;  // [Hz]
  double margin;     // two_port_margin_at()
};

/// The margin over the frequencies of the check, up to half the servo's rate.
std::vector<MarginPoint> margin_curve(const CoupledAxis& axis);

/// The largest stiffness of the coupling, with its other values as they are, that is passive with
/// the proxy fixed and has no negative margin, within a thousandth; 0: none. Less stiffness never
/// has less margin.
double largest_with_margin(CoupledAxis axis);

}  // namespace haptic
