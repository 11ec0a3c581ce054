// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/hapt/find_config.h"

#include <algorithm>
#include <filesystem>
#include <vector>

#include "proto/os/environment.h"
#include "proto/os/source_tree.h"

namespace haptic {

std::string find_config(const std::string& name) {
  std::vector<std::filesystem::path> places{name};
  if (const std::string folder = environment("HAPTICD_CONFIGS"); !folder.empty()) {
    places.push_back(std::filesystem::path(folder) / name);
  }
  if (const std::filesystem::path ours = shared_folder("configs"); !ours.empty()) {
    places.push_back(ours / name);
  }
  std::string looked;
  for (auto place = places.begin(); place != places.end(); ++place) {
    // $HAPTICD_CONFIGS may be the folder of the source tree
    if (std::find(places.begin(), place, *place) != place) continue;
    if (std::filesystem::exists(*place)) return place->string();
    looked += (looked.empty() ? "" : ", ") + place->string();
  }
  throw ConfigError(name + ": no such session file; looked at " + looked);
}

}  // namespace haptic
