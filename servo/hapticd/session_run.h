// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "proto/config/config.h"
#include "proto/ipc/control.h"
#include "proto/ipc/handout_server.h"
#include "proto/ipc/segment.h"
#include "servo/hapticd/log.h"

namespace haptic {

/// The state that people want of a hand, and the ring that tells its processes.
struct DesiredState {
  ControlFrame frame;
  SegmentWriter<ControlChannels> segment;

  explicit DesiredState(const SessionConfig& config)
      : frame(initial_control(config)), segment(1, config.hand) {}

  /// Publishes a frame that has changed, by its new revision.
  void change(int64_t t_ns) {
    ++frame.revision;
    publish(t_ns);
  }
  void publish(int64_t t_ns) {
    frame.t_ns = t_ns;
    segment.channels().frames.publish(frame);
    segment.beat(segment.channels().frames.published(), t_ns);
  }
};

/// The session that all parts of hapticd work on.
struct SessionRun {
  const std::vector<SessionConfig> hands;  // the session as each hand has it
  const std::string config_text;  // the file as read, for those who may control the session
  const std::string name;
  HapticdLog& log;
  const SessionConfig& config = hands.front();  // of what is not a hand's
  HandoutServer server{name};
  std::vector<DesiredState> desired{hands.begin(), hands.end()};  // by hand
  std::optional<int> exit_code = {};  // of hapticd; none: the session goes on

  /// The worst of several reasons gives the exit code.
  void end(int code) { exit_code = std::max(code, exit_code.value_or(code)); }
};

}  // namespace haptic
