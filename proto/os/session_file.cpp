// SPDX-License-Identifier: Apache-2.0
#include "proto/os/session_file.h"

#include <algorithm>
#include <filesystem>
#include <vector>

#include "proto/os/environment.h"
#include "proto/os/message.h"
#include "proto/os/source_tree.h"

namespace haptic {

namespace fs = std::filesystem;

namespace {

/// The current folder first; $HAPTICD_CONFIGS may be the folder of the source tree.
std::vector<fs::path> config_folders() {
  std::vector<fs::path> folders{""};
  for (const fs::path& folder :
       {fs::path(environment("HAPTICD_CONFIGS")), shared_folder("configs")}) {
    if (!folder.empty() && std::ranges::find(folders, folder) == folders.end()) {
      folders.push_back(folder);
    }
  }
  return folders;
}

/// "; did you mean 'plane'?", or nothing.
std::string guess(const std::string& name) {
  std::vector<std::string> known;
  for (const Scene& scene : kScenes) known.emplace_back(scene.name);
  for (const fs::path& folder : config_folders()) {
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder.empty() ? "." : folder, error)) {
      if (entry.path().extension() == ".toml") known.push_back(entry.path().stem().string());
    }
  }
  const std::string_view nearest =
      nearest_word(fs::path(name).stem().string(), {known.begin(), known.end()});
  return nearest.empty() ? "" : "; did you mean '" + std::string(nearest) + "'?";
}

}  // namespace

std::string find_session_file(const std::string& name) {
  std::vector<std::string> names{name};
  for (const Scene& scene : kScenes) {
    if (name == scene.name) names.emplace_back(scene.file);
  }
  if (names.size() == 1 && !name.ends_with(".toml")) names.push_back(name + ".toml");
  std::string looked;
  for (const std::string& file : names) {
    for (const fs::path& folder : config_folders()) {
      const fs::path place = folder / file;
      std::error_code error;
      if (fs::exists(place, error) && !fs::is_directory(place, error)) return place.string();
      looked += (looked.empty() ? "" : ", ") + place.string();
    }
  }
  std::error_code error;
  if (fs::exists(name, error)) return name;  // whoever reads it says that it is a folder
  throw InputError(name + ": no such session file; looked at " + looked + guess(name));
}

}  // namespace haptic
