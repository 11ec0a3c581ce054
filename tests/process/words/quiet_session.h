// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fstream>
#include <string>

#include "proto/config/config.h"
#include "tests/support/data.h"

namespace haptic::test {

/// Writes plane.toml without its wish for real time, so that its session runs beside one that has
/// it; returns the path.
inline std::string write_quiet_config(const std::string& folder) {
  std::string text = read_config_text(from_source("configs/plane.toml"));
  const std::string section = "[session]\n";
  text.insert(text.find(section) + section.size(), "realtime = false\n");
  std::ofstream(folder + "/quiet.toml") << text;
  return folder + "/quiet.toml";
}

}  // namespace haptic::test
