// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clients/log/log_columns.h"
#include "proto/log/trace.h"

namespace haptic {

/// The records of any tick of a recording, for a viewer. It holds the index and a few chunks in
/// memory, whatever the length of the file. Not for two threads at once; another thread opens the
/// file itself.
///
///   LogIndex log("out.mcap");
///   std::optional<ServoFrame> frame = log.frame_at(log.first_tick() + 5000);
///   std::unique_ptr<ContactSet> set = log.contacts_at(*frame);
///   std::optional<SceneFrame> scene = log.scene_at(*frame);
///
/// A tick here is a number of the time grid that begins with the first frame of the first column:
/// ServoFrame::tick of a servo that ran through, and it goes on when a servo was started again,
/// whose own ticks begin anew.
class LogIndex {
 public:
  /// Throws McapError: no recording, or one without servo frames.
  explicit LogIndex(const std::string& path);
  LogIndex(const LogIndex&) = delete;

  const std::vector<LogColumn>& columns() const { return columns_; }
  uint64_t first_tick() const { return first_tick_; }
  uint64_t last_tick() const { return last_tick_; }
  double rate() const { return rate_; }  // of the grid [Hz]
  /// CLOCK_MONOTONIC at a tick [ns], and the tick of an instant, rounded.
  int64_t time_of(uint64_t tick) const;
  uint64_t tick_of(int64_t t_ns) const;
  /// The file has no end yet: the recorder goes on, or was killed.
  bool is_growing() const { return !trace_.mcap().finished(); }
  /// Looks for what has been recorded since. True if there is more.
  bool refresh();

  /// The frame of this tick, or if it was skipped the last one before it; none before the first.
  /// Throws McapError if a chunk is damaged, as all below.
  std::optional<ServoFrame> frame_at(uint64_t tick, size_t column = 0);
  /// The contacts that this frame used; null if it used none, or they are not in the file.
  std::unique_ptr<ContactSet> contacts_at(const ServoFrame& frame, size_t column = 0);
  /// The scene that it used.
  std::optional<SceneFrame> scene_at(const ServoFrame& frame, size_t column = 0);
  /// All frames of these ticks, in order, first and last included.
  void for_each_frame(uint64_t from, uint64_t to, size_t column,
                      const std::function<void(const ServoFrame&)>& use);

  const TraceReader& trace() const { return trace_; }

 private:
  struct Lanes {
    TopicCursor servo, contact, sim;
  };
  void find_bounds();
  int64_t half_tick_ns() const;

  TraceReader trace_;
  std::vector<LogColumn> columns_;
  std::vector<Lanes> lanes_;  // of each column; moved to a place by whoever reads
  uint64_t first_tick_ = 0, last_tick_ = 0;
  int64_t first_ns_ = 0;
  double rate_ = 1000;
};

}  // namespace haptic
