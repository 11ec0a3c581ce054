// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "proto/math/vec3.h"

/// A mesh of one's own, as the text of a session file.
namespace haptic {

struct OwnMesh {
  std::string file, unit;  // unit as typed; empty: metres, or with a size any
  double size = 0;         // longest side, to which the mesh is scaled; 0: as the file says [m]
  bool allow_open = false;
};

/// Problem of a word for `--unit`; empty if it is one.
std::string problem_of_unit(const std::string& text);

/// The [[object]] of the mesh, with that place of it at the origin of the scene.
std::string object_text(const OwnMesh& own, const Vec3& middle_O);

/// A name made of that of the file, as sessions and objects may have it.
std::string name_of(const OwnMesh& own);

/// A session in which a simulated hand strokes the mesh (mesh_strokes.h). Bakes the mesh to know
/// how large it is. Throws MeshError.
std::string session_text(const OwnMesh& own);

}  // namespace haptic
