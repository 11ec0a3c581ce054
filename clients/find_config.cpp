// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/find_config.h"

#include <cstdlib>
#include <filesystem>
#include <vector>

namespace haptic {

std::string find_config(const std::string& name) {
  std::vector<std::filesystem::path> places{name};
  if (const char* folder = std::getenv("HAPTICD_CONFIGS"); folder != nullptr) {
    places.push_back(std::filesystem::path(folder) / name);
  }
  places.push_back(std::filesystem::path(HAPTICD_SOURCE_DIR) / "configs" / name);
  places.push_back(std::filesystem::path("/usr/share/hapticd/configs") / name);
  std::string looked;
  for (const auto& place : places) {
    if (std::filesystem::exists(place)) return place.string();
    looked += (looked.empty() ? "" : ", ") + place.string();
  }
  throw ConfigError(name + ": no such session file; looked at " + looked);
}

}  // namespace haptic
