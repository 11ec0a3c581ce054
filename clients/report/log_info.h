// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <ostream>
#include <set>
#include <string>
#include <vector>

namespace haptic {

/// A topic of a recording.
struct TopicSummary {
  std::string topic, schema;
  uint64_t count = 0;
  double rate = 0;   // of its messages, from the first to the last [Hz]; 0: fewer than two
  bool ours = true;  // records of this program; others are counted only
  uint64_t lost = 0;
};

/// The summary of a recording that `hapt info` prints.
struct LogInfo {
  std::string path, session, version, abi, host;
  std::string notice;         // what records of an older layout lack; empty: nothing
  int64_t begin_ns = 0;       // CLOCK_REALTIME of the first message
  double duration = 0;        // from the first message to the last [s]
  uint64_t bytes = 0;         // of the file
  bool was_finished = false;  // the file has its end: the recorder was not killed
  bool has_config = false;    // the session file is inside
  bool knows_losses = false;  // the recorder has counted what it lost
  uint64_t lost = 0;
  std::vector<TopicSummary> topics;
  std::vector<std::string> columns;  // of a comparison; else empty
  // of the servo's frames, of all columns
  uint64_t frames = 0, touching = 0, late_ticks = 0, fault_ticks = 0;
  double max_force = 0;  // at the device [N]
  std::set<std::string> renderers, faults;
};

/// Reads a whole recording; `told` hears the share that has been read. Throws McapError.
LogInfo read_log_info(const std::string& path, const std::function<void(double)>& told = {});

void print_info(std::ostream& out, const LogInfo& info);
/// One object.
void print_info_json(std::ostream& out, const LogInfo& info);

}  // namespace haptic
