// SPDX-License-Identifier: Apache-2.0
#include "proto/os/source_tree.h"

#include "proto/os/environment.h"
#include "proto/os/programs.h"

namespace haptic {

namespace fs = std::filesystem;

fs::path source_tree() {
  if (const std::string named = environment("HAPTICD_SOURCE"); !named.empty()) return named;
  for (fs::path folder = own_folder(); folder.has_relative_path(); folder = folder.parent_path()) {
    std::error_code error;
    if (fs::is_directory(folder / "configs", error) &&
        fs::is_regular_file(folder / "CMakeLists.txt", error)) {
      return folder;
    }
  }
  return {};
}

}  // namespace haptic
