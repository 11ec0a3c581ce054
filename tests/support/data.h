// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <iostream>
#include <optional>
#include <string>

#include "proto/environment.h"

namespace haptic::test {

/// A file of the folder that `variable` names, else of `fallback` in the source tree; or nothing,
/// said loudly: a test that needs it then has nothing to do.
inline std::optional<std::string> find_or_skip(const std::string& name, const char* variable,
                                               const char* fallback, const char* mend) {
  std::filesystem::path folder = environment(variable);
  if (folder.empty()) folder = std::filesystem::path(HAPTIC_SOURCE_DIR) / fallback;
  const std::filesystem::path path = folder / name;
  if (std::filesystem::exists(path)) return path.string();
  std::cerr << "SKIPPED: " << path.string() << " is not here; " << mend << '\n';
  return std::nullopt;
}

/// A recording: in $HAPTICD_DATA, else in ../shared/data beside the source tree.
inline std::optional<std::string> find_data(const std::string& name) {
  return find_or_skip(name, "HAPTICD_DATA", "../shared/data", "set HAPTICD_DATA to run this test");
}

/// A mesh of Debian's libcgal-demo: in $HAPTICD_MESHES, else in build/meshes.
inline std::optional<std::string> find_mesh(const std::string& name) {
  return find_or_skip(name, "HAPTICD_MESHES", "build/meshes", "`./run meshes` fetches it");
}

}  // namespace haptic::test
