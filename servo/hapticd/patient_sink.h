// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <spdlog/details/null_mutex.h>
#include <spdlog/sinks/base_sink.h>

#include <cstdint>
#include <deque>
#include <string>

namespace haptic {

/// Writes log lines to a descriptor that may stop accepting them (a terminal after Ctrl-S, a pager,
/// a stalled journal) without ever waiting for it. At most kMostLines are kept; the oldest are
/// dropped, counted, and reported once writing is possible again. A write of up to PIPE_BUF bytes
/// does not block where poll() reports room (pipe(7)), so longer lines are written in pieces.
class PatientSink : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
 public:
  static constexpr size_t kMostLines = 2000;

  explicit PatientSink(int fd);

  /// Writes what can be written now.
  void drain();
  /// drain(), waiting up to that long for the reader [ns].
  void drain_for(int64_t patience_ns);

  uint64_t dropped() const { return dropped_; }

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override;
  void flush_() override { drain(); }

 private:
  bool has_room(int timeout_ms) const;
  bool write_some();

  int fd_;
  bool colours_;
  std::deque<std::string> lines_;  // of the first what is not yet written
  uint64_t dropped_ = 0, told_ = 0;
};

}  // namespace haptic
