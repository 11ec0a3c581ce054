// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/patient_sink.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>

#include "proto/os/realtime.h"

namespace haptic {
namespace {

std::string_view colour_of(spdlog::level::level_enum level) {
  return level == spdlog::level::warn  ? "\033[33m\033[1m"
         : level == spdlog::level::err ? "\033[31m\033[1m"
                                       : "\033[32m";
}

constexpr std::string_view kPlain = "\033[m";

}  // namespace

PatientSink::PatientSink(int fd) : fd_(fd), colours_(isatty(fd) == 1) {}

void PatientSink::sink_it_(const spdlog::details::log_msg& message) {
  spdlog::memory_buf_t text;
  formatter_->format(message, text);
  std::string line(text.data(), text.size());
  if (colours_ && message.color_range_end > message.color_range_start) {
    line.insert(message.color_range_end, kPlain);
    line.insert(message.color_range_start, colour_of(message.level));
  }
  if (lines_.size() >= kMostLines) {
    // keeps the first line, which may be half written
    lines_.erase(lines_.begin() + 1);
    ++dropped_;
  }
  lines_.push_back(std::move(line));
}

bool PatientSink::has_room(int timeout_ms) const {
  pollfd waiting{fd_, POLLOUT, 0};
  return poll(&waiting, 1, timeout_ms) > 0 && (waiting.revents & POLLOUT) != 0;
}

/// Writes a piece of the first line; false: the descriptor accepts nothing.
bool PatientSink::write_some() {
  std::string& line = lines_.front();
  const ssize_t n = write(fd_, line.data(), std::min<size_t>(line.size(), PIPE_BUF));
  if (n < 0) return errno == EINTR;
  line.erase(0, static_cast<size_t>(n));
  if (!line.empty()) return true;
  lines_.pop_front();
  if (dropped_ > told_) {
    lines_.push_front("hapticd: " + std::to_string(dropped_ - told_) +
                      " lines of the log were dropped: nobody read them\n");
    told_ = dropped_;
  }
  return true;
}

void PatientSink::drain() {
  while (!lines_.empty() && has_room(0) && write_some()) {
  }
}

void PatientSink::drain_for(int64_t patience_ns) {
  const int64_t give_up_ns = now_ns() + patience_ns;
  while (!lines_.empty() && now_ns() < give_up_ns) {
    const auto left_ms = static_cast<int>((give_up_ns - now_ns()) / 1'000'000 + 1);
    if (has_room(left_ms) && !write_some()) return;
  }
}

}  // namespace haptic
