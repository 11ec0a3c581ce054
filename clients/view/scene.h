// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "clients/log/log_survey.h"
#include "clients/view/tightest.h"
#include "clients/view/view.h"
#include "clients/view/web/web.h"
#include "proto/config/config.h"

namespace haptic {

/// The eye files of a scene (docs/view-protocol.md), as hapticd hands them out; null where there is
/// none.
struct EyeFiles {
  SharedText tool;
  std::vector<SharedText> objects;
  SharedText tool_pieces;
  std::vector<SharedText> object_pieces;
};

/// The properties that only a log has.
struct LogFacts {
  uint64_t first_tick = 0, last_tick = 0;
  double first_time = 0, last_time = 0;   // [s], of the session's clock
  bool growing = false;                   // it is still written
  std::vector<LogMark> marks;             // in the order of their ticks
  std::optional<TightestPlace> tightest;  // where it was measured
};

/// The content of a session or a log, as far as the bridge is told.
struct SceneInfo {
  std::string session;
  std::string config_text;              // empty: not given to this user
  std::optional<SessionConfig> config;  // of that text
  EyeFiles eyes;
  double started = -1;          // [s], of the session's clock; below zero: not known
  std::optional<LogFacts> log;  // of a log
};

/// Reads the text of a session file into the info; one that cannot be read here leaves the config
/// empty and returns why.
std::string use_config(SceneInfo& info, const std::string& text);

/// The content of /scene.json. The text of the session file may hold comments and paths: only who
/// may control is given it.
std::string scene_json(const SceneInfo& info, const View& view, bool with_config);

}  // namespace haptic
