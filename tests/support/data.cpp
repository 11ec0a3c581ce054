// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/data.h"

#include <filesystem>
#include <iostream>

#include "proto/os/environment.h"
#include "proto/os/source_tree.h"

namespace haptic::test {

std::string from_source(const std::string& path) {
  return (source_tree() / path).string();
}

std::optional<std::string> find_mesh(const std::string& name) {
  std::filesystem::path folder = environment("HAPTICD_MESHES");
  if (folder.empty()) folder = from_source("build/meshes");
  const std::filesystem::path path = folder / name;
  if (std::filesystem::exists(path)) return path.string();
  std::cerr << "SKIPPED: " << path.string() << " is not here; `./run meshes` fetches it\n";
  return std::nullopt;
}

}  // namespace haptic::test
