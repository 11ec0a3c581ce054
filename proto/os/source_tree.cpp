// SPDX-License-Identifier: Apache-2.0
#include "proto/os/source_tree.h"

#include <algorithm>
#include <cstring>
#include <initializer_list>

#include "proto/os/environment.h"
#include "proto/os/programs.h"

namespace haptic {

namespace fs = std::filesystem;

namespace {

/// The nearest folder above the program that has all of these; empty: none.
fs::path nearest_with(std::initializer_list<const char*> entries) {
  for (fs::path folder = own_folder(); folder.has_relative_path(); folder = folder.parent_path()) {
    const auto is_there = [&](const char* entry) {
      std::error_code error;
      return fs::exists(folder / entry, error);
    };
    if (std::all_of(entries.begin(), entries.end(), is_there)) return folder;
  }
  return {};
}

}  // namespace

fs::path source_tree() {
  const std::string named = environment("HAPTICD_SOURCE");
  return named.empty() ? nearest_with({"configs/", "CMakeLists.txt"}) : fs::path(named);
}

fs::path shared_folder(const std::string& what) {
  if (const fs::path tree = source_tree(); !tree.empty()) {
    return what == "meshes" ? tree / "build" / what : tree / what;
  }
  const fs::path prefix = nearest_with({"share/hapticd/"});
  return prefix.empty() ? prefix : prefix / "share" / "hapticd" / what;
}

std::string cannot_start(const std::string& path, int error) {
  const std::string name = fs::path(path).filename();
  std::string mend = name == "hapt-lab"
                         ? "it measures and tests hapticd, which the packages leave to the source: "
                           "clone it, then ./run build"
                         : "it belongs to the package hapticd; install that again";
  if (!environment("HAPTICD_LIBEXEC").empty()) {
    mend = "HAPTICD_LIBEXEC has to name the folder of all programs";
  } else if (!source_tree().empty()) {
    mend = name == "haptic-view" ? "`./run demo --view` builds it, as does `./run build`"
                                 : "`./run build` builds it";
  }
  return path + ": cannot be started (" + std::strerror(error) + "); " + mend;
}

fs::path fetched_meshes() {
  const std::string data = environment("XDG_DATA_HOME"), home = environment("HOME");
  if (data.empty() && home.empty()) return {};
  return (data.empty() ? fs::path(home) / ".local" / "share" : fs::path(data)) / "hapticd/meshes";
}

}  // namespace haptic
