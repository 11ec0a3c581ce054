// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/data.h"

#include <filesystem>
#include <iostream>

#include "proto/os/environment.h"
#include "proto/os/source_tree.h"

namespace haptic::test {
namespace {

std::optional<std::string> find_or_skip(const std::string& name, const char* variable,
                                        const char* fallback, const char* mend) {
  std::filesystem::path folder = environment(variable);
  if (folder.empty()) folder = from_source(fallback);
  const std::filesystem::path path = folder / name;
  if (std::filesystem::exists(path)) return path.string();
  std::cerr << "SKIPPED: " << path.string() << " is not here; " << mend << '\n';
  return std::nullopt;
}

}  // namespace

std::string from_source(const std::string& path) {
  return (source_tree() / path).string();
}

std::optional<std::string> find_data(const std::string& name) {
  return find_or_skip(name, "HAPTICD_DATA", "../shared/data", "set HAPTICD_DATA to run this test");
}

std::optional<std::string> find_mesh(const std::string& name) {
  return find_or_skip(name, "HAPTICD_MESHES", "build/meshes", "`./run meshes` fetches it");
}

}  // namespace haptic::test
