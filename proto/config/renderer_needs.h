// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "proto/config/session_config.h"
#include "proto/wire/renderer.h"

namespace haptic {

/// The springs of a coupling [N/m], [N·m/rad].
struct Springs {
  double translational = 0, rotational = 0;
};

/// The solver of a renderer of a soft body: the session's, or the renderer's own.
inline SoftSolver solver_of(const ProxyConfig& proxy, Renderer renderer) {
  return proxy.solver.value_or(row_of(renderer).soft);
}

/// True if a coupling pulls a proxy of the tool; false: the hand meets the contacts directly.
inline bool has_springs(SoftSolver solver, Renderer renderer) {
  return is_rigid(renderer) || solver != SoftSolver::kDirect;
}
inline bool has_springs(const ProxyConfig& proxy, Renderer renderer) {
  return has_springs(solver_of(proxy, renderer), renderer);
}

/// True if contact bakes voxels of the objects and points of the tool, should there be a tool.
inline bool has_maps(const SessionConfig& config) {
  return row_of(config.renderer).has_maps || config.voxel.is_wanted != 0;
}

/// True if contact bakes convex pieces of the objects and the tool, should there be a tool.
inline bool has_pieces(const SessionConfig& config) {
  return row_of(config.renderer).has_pieces || config.pieces.is_wanted != 0;
}

/// The data that contact has baked for a tool with six degrees of freedom.
struct BakedFor {
  bool maps = false, pieces = false;
};
inline BakedFor baked_for(const SessionConfig& config) {
  return {has_maps(config), has_pieces(config)};
}

/// Says what a session lacks to be rendered by another renderer, where that moves a soft body with
/// this solver, and what to add to its file; empty: nothing. `baked` is what contact has of the
/// objects.
std::string lack_of(const SessionConfig& config, Renderer renderer, SoftSolver solver,
                    const Springs& springs, const BakedFor& baked);

/// The row of that name; null: there is none.
const RendererRow* find_renderer(std::string_view name);

/// The names of all renderers, for a message.
std::string renderer_names();
/// A message that there is no renderer of that name, and which was meant.
std::string unknown_renderer(std::string_view name);

/// Gives a session that has not begun another renderer, by its name. Throws ConfigError where there
/// is none of that name, or the session lacks what it needs.
void use_renderer(SessionConfig& config, std::string_view name);

}  // namespace haptic
