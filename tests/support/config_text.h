// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <catch2/catch.hpp>
#include <string>

#include "proto/config/config.h"
#include "tests/support/hostile_text.h"

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

/// The lines 9 and 10.
inline const std::string kBox = kScene.substr(kScene.find("primitive"));

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
  return refusal<ConfigError>([&] { parse_config(text, "x.toml"); });
}

/// A session of kScene with one line replaced.
inline SessionConfig session_with(const std::string& old, const std::string& text) {
  return parse_config(scene_with(old, text), "x.toml");
}

/// Its object, as these keys describe it.
inline ObjectConfig object_with(const std::string& keys) {
  return session_with(kBox, keys).objects[0];
}

/// A mistake, its place and the expected message, which is one line.
struct Bad {
  std::string text, place, says;

  void check() const {
    const std::string error = error_of(text);
    CAPTURE(text);
    CHECK_THAT(error, Catch::StartsWith("x.toml:" + place) && Catch::Contains(says));
    CHECK(error.find('\n') == std::string::npos);
  }
};

}  // namespace haptic::test
