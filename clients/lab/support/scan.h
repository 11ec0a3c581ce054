// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "contact/bake/bake.h"

namespace haptic {

/// A scan from a file, scaled so that its longest side is `size` [m]; open ones are one-sided
/// surfaces. Throws MeshError.
BakedShape bake_scan(const std::string& file, double size);

/// Default folder of scans: $HAPTICD_MESHES, else build/meshes in the source tree.
std::string meshes_folder();

/// Place along y, between `low` and `high`, from which on a tool above an object is free of it.
double lowest_free(const MeshShape& object, const MeshShape& tool, double low, double high);

}  // namespace haptic
