// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <catch2/catch.hpp>
#include <string>

#include "proto/config/config.h"

namespace haptic::test {

// line numbers matter below
inline const std::string kScene =
    "[session]\n"                                    // 1
    "name = \"test\"\n"                              // 2
    "[device]\n"                                     // 3
    "kind = \"simulated-hand\"\n"                    // 4
    "[coupling]\n"                                   // 5
    "stiffness = \"800 N/m\"\n"                      // 6
    "[[object]]\n"                                   // 7
    "name = \"block\"\n"                             // 8
    "primitive = \"box\"\n"                          // 9
    "extent = [\"80 mm\", \"8 cm\", \"0.08 m\"]\n";  // 10

/// kScene with one line replaced; an empty `old` appends.
inline std::string scene_with(const std::string& old, const std::string& text) {
  std::string scene = kScene;
  if (old.empty()) return scene + text;
  const size_t at = scene.find(old);
  REQUIRE(at != std::string::npos);
  return scene.replace(at, old.size(), text);
}

/// The error message for this text; empty if it is accepted.
inline std::string error_of(const std::string& text) {
  try {
    parse_config(text, "x.toml");
    return "";
  } catch (const ConfigError& error) {
    return error.what();
  }
}

/// A mistake, its position and the expected message.
struct Bad {
  std::string what, text, place, says;
};

}  // namespace haptic::test
