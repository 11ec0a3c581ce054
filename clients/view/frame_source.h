// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "clients/view/scene.h"
#include "clients/view/view.h"

namespace haptic {

enum class SourceNews {
  kNothing,
  kArrived,  // a session or log is there: scene() is new
  kChanged,  // scene() is new, of the same session or log
  kGone,     // it is no longer
};

/// Where frames come from: a running session, or a log that is played. The bridge knows no more of
/// it than these functions, which are called on its one thread and never wait.
struct FrameSource {
  std::string kind;  // "session" or "log"
  std::function<SourceNews(int64_t now_ns)> advance;
  std::function<const View&()> view;
  std::function<const SceneInfo&()> scene;
  std::function<double()> missed;  // [s] without it before it arrived; below zero: the first time
};

}  // namespace haptic
