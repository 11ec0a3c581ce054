// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
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

class Drawings;
class LogSource;

/// A source of frames: a running session, or a log that is played. The bridge calls these
/// functions on its one thread, and they never wait. All viewers of a session see the same view;
/// of a log each page has its own, of the columns that there are.
struct FrameSource {
  std::string kind;  // "session" or "log"
  std::function<SourceNews(int64_t now_ns)> advance;
  std::function<const View&()> view;
  std::function<const SceneInfo&()> scene;
  std::function<double()> missed;  // [s] without it before it arrived; below zero: the first time
  std::shared_ptr<LogSource> log = nullptr;  // null: a session
  // what clients draw; null: of a log, or there is no session
  std::function<Drawings*()> drawings = [] { return nullptr; };
};

}  // namespace haptic
