// SPDX-License-Identifier: Apache-2.0
#include "proto/config/renderer_needs.h"

#include <algorithm>

#include "proto/os/message.h"

namespace haptic {

std::string lack_of(const SessionConfig& config, Renderer renderer, SoftSolver solver,
                    const Springs& springs, const BakedFor& baked) {
  if (!is_of_body(renderer)) return "";
  if (!has_mesh(config.tool)) {
    return "moves a tool with six degrees of freedom, and this session has a point; add [tool] to "
           "its file";
  }
  if (row_of(renderer).has_maps && !baked.maps) {
    return "asks maps of voxels, and this session has none; add [contact.voxel] to its file";
  }
  if (row_of(renderer).has_pieces && !baked.pieces) {
    return "asks convex pieces, and this session has none; add [contact.pieces] to its file";
  }
  if (!has_springs(solver, renderer)) return "";
  if (springs.translational > 0 && springs.rotational > 0) return "";
  return "has a proxy that moves and turns, and needs stiffness and rotational-stiffness above "
         "zero";
}

const RendererRow* find_renderer(std::string_view name) {
  const auto row = std::find_if(kRenderers.begin(), kRenderers.end(),
                                [&](const RendererRow& one) { return one.name == name; });
  return row == kRenderers.end() ? nullptr : &*row;
}

std::string renderer_names() {
  return joined(kRenderers, &RendererRow::name);
}

std::string unknown_renderer(std::string_view name) {
  std::vector<std::string_view> known;
  for (const RendererRow& row : kRenderers) known.push_back(row.name);
  return "there is no renderer '" + shown(name) + "'; " + suggestion(name, known);
}

void use_renderer(SessionConfig& config, std::string_view name) {
  const RendererRow* row = find_renderer(name);
  if (row == nullptr) {
    throw ConfigError(unknown_renderer(name));
  }
  const Springs springs{config.coupling.translational_stiffness,
                        config.coupling.rotational_stiffness};
  // maps and pieces are baked for the renderer that a session begins with
  const std::string lack =
      lack_of(config, row->id, solver_of(config.proxy, row->id), springs, {true, true});
  if (!lack.empty()) {
    throw ConfigError(std::string(view(config.file)) + ": renderer '" + std::string(name) + "' " +
                      lack);
  }
  config.renderer = row->id;
}

}  // namespace haptic
