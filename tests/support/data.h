// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>

namespace haptic::test {

/// A file of the recordings folder ($HAPTICD_DATA, else ../shared/data beside the source tree), or
/// nothing, said loudly: a test that needs it then has nothing to do.
inline std::optional<std::string> find_data(const std::string& name) {
  const char* folder = std::getenv("HAPTICD_DATA");
  const auto path =
      (folder != nullptr ? std::filesystem::path(folder)
                         : std::filesystem::path(HAPTIC_SOURCE_DIR) / "../shared/data") /
      name;
  if (std::filesystem::exists(path)) return path.string();
  std::cerr << "SKIPPED: " << path.string() << " is not here; set HAPTICD_DATA to run this test\n";
  return std::nullopt;
}

/// A mesh that `./run meshes` unpacks ($HAPTICD_MESHES, else build/meshes), or nothing, said
/// loudly.
inline std::optional<std::string> find_mesh(const std::string& name) {
  const char* folder = std::getenv("HAPTICD_MESHES");
  const auto path =
      (folder != nullptr ? std::filesystem::path(folder)
                         : std::filesystem::path(HAPTIC_SOURCE_DIR) / "build/meshes") /
      name;
  if (std::filesystem::exists(path)) return path.string();
  std::cerr << "SKIPPED: " << path.string() << " is not here; `./run meshes` fetches it\n";
  return std::nullopt;
}

}  // namespace haptic::test
