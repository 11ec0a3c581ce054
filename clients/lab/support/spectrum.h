// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "proto/math/vec3.h"

namespace haptic {

/// Root mean square of a force sampled at `rate` [Hz] over its frequencies above `cutoff` [Hz], by
/// the discrete Fourier transform under a Hann window; by Parseval what is below is subtracted from
/// the whole. The window spreads each line over two neighbours, rate/size apart.
double rms_above(std::span<const Vec3> force, double rate, double cutoff);

}  // namespace haptic
