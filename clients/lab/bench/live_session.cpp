// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/live_session.h"
#include "proto/ipc/sessions.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <stdexcept>

namespace haptic {
namespace {

constexpr int64_t kPatience = 20 * kNsPerSecond;     // [ns]; only a broken session takes so long
constexpr int64_t kLookPeriod = kNsPerSecond / 100;  // [ns]
constexpr int64_t kSettle = kNsPerSecond;  // in which readers touch the pages of their segments

}  // namespace

RuntimeFolder::RuntimeFolder() {
  setenv("HAPTICD_RUNTIME_DIR", path().c_str(), 1);
}

void wait_until(const std::string& what, const std::function<bool()>& holds) {
  for (const int64_t begin = now_ns(); !holds(); sleep_until(now_ns() + kLookPeriod)) {
    if (now_ns() - begin > kPatience) throw std::runtime_error("bench: " + what);
  }
}

LiveSession::LiveSession(const RuntimeFolder& folder, const std::string& session,
                         const std::string& config)
    : hapticd_("hapticd", {config, "--session", session}, folder.path() + "/" + session + ".log") {
  wait_until("hapticd does not start", [&] {
    const auto names = running_sessions();
    return std::find(names.begin(), names.end(), session) != names.end();
  });
  client_.emplace(session);
  frames_.emplace(client_->ring<&ServoChannels::frames>(Start::kNewest));
  sets_.emplace(client_->ring<&ContactChannels::sets>(Start::kNewest));
  client_->start();
  ServoFrame frame;
  wait_until("the servo does not run", [&] {
    return frames_->latest(frame) && (frame.flags & kServoPaused) == 0 && frame.contact_seq > 0;
  });
  sleep_until(now_ns() + kSettle);
}

SessionWindow LiveSession::watch(double seconds) {
  ServoFrame frame;
  const auto set = std::make_unique<ContactSet>();
  frames_->latest(frame);
  sets_->latest(*set);
  Histogram busy, wake, steps;
  uint64_t n_sets = 0, n_frames = 0, n_contacts = 0;
  const int64_t begin = now_ns(), end = begin + static_cast<int64_t>(1e9 * seconds);
  while (now_ns() < end) {
    sleep_until(now_ns() + kLookPeriod);
    while (frames_->next(frame)) {
      busy.add(frame.busy_ns);
      wake.add(frame.wake_late_ns);
      n_contacts += frame.n_contacts;
      ++n_frames;
    }
    for (; sets_->next(*set); ++n_sets) steps.add(set->busy_ns);
  }
  const double lasted = 1e-9 * static_cast<double>(now_ns() - begin);
  const auto percentile = [](const Histogram& times, double q) {
    return 1e-9 * static_cast<double>(times.percentile(q));
  };
  return {.busy_p50 = percentile(busy, 50),
          .busy_p99 = percentile(busy, 99),
          .wake_p99 = percentile(wake, 99),
          .contact_p50 = percentile(steps, 50),
          .contact_p99 = percentile(steps, 99),
          .contact_rate = static_cast<double>(n_sets) / lasted,
          .contacts = static_cast<double>(n_contacts) /
                      static_cast<double>(std::max<uint64_t>(n_frames, 1)),
          .seconds = lasted};
}

}  // namespace haptic
