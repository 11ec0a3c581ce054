// SPDX-License-Identifier: Apache-2.0
#include "clients/log/log_index.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic {
namespace {

constexpr size_t kMostKept = 32;        // chunks kept unpacked; 8 MiB as the recorder writes them
constexpr int64_t kAhead = 50'000'000;  // [ns] of a scene, whose instant may be a little later
constexpr int64_t kOldest = 2'000'000'000;  // [ns] of contacts: longer than any are used
constexpr int kRateFrames = 100;            // that tell the rate of the grid

/// Rate of the grid [Hz], from two of its instants; exact to a hundredth of a hertz.
double rate_of(int64_t span_ns, uint64_t ticks) {
  if (span_ns <= 0 || ticks == 0) return 1000;
  return std::round(1e11 * static_cast<double>(ticks) / static_cast<double>(span_ns)) / 100;
}

}  // namespace

LogIndex::LogIndex(const std::string& path)
    : trace_(path, kMostKept), columns_(log_columns(trace_)) {
  if (columns_.empty()) {
    throw McapError(path + ": has no servo frames; name a recording of a session");
  }
  for (const LogColumn& column : columns_) {
    lanes_.push_back({{trace_, info_of(Topic<ServoFrame>{column.servo})},
                      {trace_, info_of(Topic<ContactSet>{column.contact})},
                      {trace_, info_of(Topic<SceneFrame>{column.sim})}});
  }
  find_bounds();
}

bool LogIndex::refresh() {
  if (!trace_.mcap().refresh()) return false;
  find_bounds();
  return true;
}

void LogIndex::find_bounds() {
  TopicCursor& servo = lanes_[0].servo;
  servo.rewind();
  if (!servo.next()) return;
  const auto first = servo.read<ServoFrame>();
  first_tick_ = first.tick;
  first_ns_ = servo.stamp().t_ns;
  ServoFrame later = first;
  for (int i = 0; i < kRateFrames && servo.next(); ++i) {
    const auto next = servo.read<ServoFrame>();
    if (next.tick <= later.tick) break;
    later = next;
  }
  rate_ = rate_of(later.t_ns - first.t_ns, later.tick - first.tick);
  servo.seek(std::numeric_limits<int64_t>::max() - 1);
  last_tick_ = tick_of(servo.stamp().t_ns);
}

int64_t LogIndex::time_of(uint64_t tick) const {
  const auto ticks = static_cast<double>(tick) - static_cast<double>(first_tick_);
  return first_ns_ + std::llround(ticks * 1e9 / rate_);
}

int64_t LogIndex::half_tick_ns() const {
  return static_cast<int64_t>(0.5e9 / rate_);
}

uint64_t LogIndex::tick_of(int64_t t_ns) const {
  const double ticks = std::round(1e-9 * static_cast<double>(t_ns - first_ns_) * rate_);
  return first_tick_ + static_cast<uint64_t>(std::max(ticks, 0.0));
}

std::optional<ServoFrame> LogIndex::frame_at(uint64_t tick, size_t column) {
  TopicCursor& servo = lanes_.at(column).servo;
  if (!servo.seek(time_of(tick) + half_tick_ns())) return std::nullopt;
  return servo.read<ServoFrame>();
}

std::unique_ptr<ContactSet> LogIndex::contacts_at(const ServoFrame& frame, size_t column) {
  if ((frame.flags & kServoNoContactSet) != 0) return nullptr;
  TopicCursor& contact = lanes_.at(column).contact;
  for (bool has = contact.seek(frame.t_ns); has; has = contact.previous()) {
    auto set = std::make_unique<ContactSet>(contact.read<ContactSet>());
    if (set->seq == frame.contact_seq && set->answers_tick == frame.contact_tick) return set;
    const bool is_before = set->answers_tick < frame.contact_tick;
    if (is_before || contact.stamp().t_ns < frame.t_ns - kOldest) break;
  }
  return nullptr;
}

std::optional<SceneFrame> LogIndex::scene_at(const ServoFrame& frame, size_t column) {
  TopicCursor& sim = lanes_.at(column).sim;
  // sim may have published an instant that is a little ahead
  for (bool has = sim.seek(frame.t_ns + kAhead); has; has = sim.previous()) {
    const auto scene = sim.read<SceneFrame>();
    if (scene.seq == frame.scene_seq) return scene;
    if (scene.seq < frame.scene_seq) break;
  }
  return std::nullopt;
}

void LogIndex::for_each_frame(uint64_t from, uint64_t to, size_t column,
                              const std::function<void(const ServoFrame&)>& use) {
  TopicCursor& servo = lanes_.at(column).servo;
  const int64_t begin_ns = time_of(from) - half_tick_ns(), end_ns = time_of(to) + half_tick_ns();
  for (bool has = servo.seek(begin_ns) || servo.next(); has; has = servo.next()) {
    const int64_t t_ns = servo.stamp().t_ns;
    if (t_ns > end_ns) return;
    if (t_ns >= begin_ns) use(servo.read<ServoFrame>());
  }
}

}  // namespace haptic
