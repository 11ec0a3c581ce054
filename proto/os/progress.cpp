// SPDX-License-Identifier: Apache-2.0
#include "proto/os/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int64_t kPeriodNs = kNsPerSecond / 4;  // between two looks of the line

}  // namespace

Progress::Progress(std::string what, double total)
    : what_(std::move(what)),
      total_(total),
      is_terminal_(isatty(STDERR_FILENO) == 1),
      start_ns_(now_ns()),
      last_ns_(start_ns_ + kNsPerSecond - kPeriodNs) {}

Progress::~Progress() {
  if (is_shown_) std::fputs("\r\033[K", stderr);
}

void Progress::at(double done) {
  done_ = done;
  if (!is_terminal_ || now_ns() - last_ns_ < kPeriodNs) return;
  last_ns_ = now_ns();
  is_shown_ = true;
  const double share = std::clamp(done / std::max(total_, 1.0), 0.0, 1.0);
  const double seconds = static_cast<double>(last_ns_ - start_ns_) * 1e-9;
  std::fprintf(stderr, "\r  %s: %.0f %%, %s\033[K", what_.c_str(), 100 * share,
               time_left(share, seconds).c_str());
}

void StageProgress::at(std::string_view stage, double share) {
  if (!progress_ || stage != stage_) progress_.emplace(stage_ = stage, 1);
  progress_->at(share);
  if (share >= 1) progress_.reset();
}

std::string time_left(double share, double seconds) {
  if (!(share > 1e-6)) return "time left unknown";
  const double left = std::ceil(seconds * (1 - share) / share);
  constexpr double kMinute = 60;
  const bool is_long = left > 2 * kMinute;
  return "about " + std::to_string(std::lround(is_long ? left / kMinute : left)) +
         (is_long ? " min" : " s") + " left";
}

}  // namespace haptic
