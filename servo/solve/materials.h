// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>

#include "proto/config/config.h"

namespace haptic {

/// The materials of the objects, for the solvers of all renderers. The world has the usual one.
struct Materials {
  std::array<MaterialConfig, kMaxObjects + 1> of_object{};
  std::array<HeightImage, kMaxImages> images{};  // of their textures

  const MaterialConfig& of(uint32_t object) const { return of_object[std::min(object, kNoObject)]; }
};

}  // namespace haptic
