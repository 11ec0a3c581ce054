// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string_view>
#include <utility>

#include "proto/wire/wire.h"

namespace haptic {

/// The names of the (detector, solver) pairs, as they stand in a config.
inline constexpr std::array<std::pair<std::string_view, Renderer>, 7> kRenderers{
    {{"god-object3", Renderer::kGodObject3},
     {"penalty3", Renderer::kPenalty3},
     {"virtual-proxy3", Renderer::kVirtualProxy3},
     {"direct6", Renderer::kDirect6},
     {"voxel", Renderer::kVoxel},
     {"god-object6", Renderer::kGodObject6},
     {"constrained6", Renderer::kConstrained6}}};

/// Whether a number on the wire names a renderer.
constexpr bool is_renderer(uint32_t number) {
  return number < kRenderers.size();
}

/// Whether its tool has six degrees of freedom and never enters an object.
constexpr bool is_rigid(Renderer renderer) {
  return renderer == Renderer::kGodObject6 || renderer == Renderer::kConstrained6;
}

/// Whether it moves a tool with six degrees of freedom instead of a point.
constexpr bool is_of_body(Renderer renderer) {
  return renderer == Renderer::kDirect6 || renderer == Renderer::kVoxel || is_rigid(renderer);
}

/// The name of a renderer, as it stands in a config.
constexpr std::string_view name_of(Renderer renderer) {
  for (const auto& [name, one] : kRenderers) {
    if (one == renderer) return name;
  }
  return "?";
}

}  // namespace haptic
