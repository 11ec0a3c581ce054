// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

namespace haptic::test {

/// A file or folder of the source tree by its path from the root. Looked up at run time: a path
/// compiled into the binary would be wrong for a cached object file.
std::string from_source(const std::string& path);

/// A recording or a folder of queries by its path from tests/data.
inline std::string data_file(const std::string& name) {
  return from_source("tests/data/" + name);
}

/// A mesh of Debian's libcgal-demo in $HAPTICD_MESHES, else in build/meshes; nothing, with a
/// warning, if absent: tests that need it are then empty.
std::optional<std::string> find_mesh(const std::string& name);

}  // namespace haptic::test
