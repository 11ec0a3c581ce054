// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>

#include "contact/detect/detector.h"
#include "proto/math/assert.h"

namespace haptic {

#define RENDERER(id, name, detector, ...) Detect detector;
#include "proto/wire/renderers.def"

Detect& detector_of(Renderer renderer) {
  static constexpr std::array kDetectors{
#define RENDERER(id, name, detector, ...) &detector,
#include "proto/wire/renderers.def"
  };
  HAPTIC_ASSERT(static_cast<size_t>(renderer) < kDetectors.size());
  return *kDetectors[static_cast<size_t>(renderer)];
}

}  // namespace haptic
