// SPDX-License-Identifier: Apache-2.0
#include "clients/log/log_index.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace haptic {
namespace {

constexpr size_t kMostLoaded = 32;      // chunks kept unpacked; 8 MiB as the recorder writes them
constexpr int64_t kAhead = 50'000'000;  // [ns] of a scene, whose instant may be a little later
constexpr int64_t kOldest = 2'000'000'000;  // [ns] of contacts: longer than any are used

/// Rate of the grid [Hz], from two of its instants; exact to a hundredth of a hertz.
double rate_of(int64_t span_ns, uint64_t ticks) {
  if (span_ns <= 0 || ticks == 0) return 1000;
  return std::round(1e11 * static_cast<double>(ticks) / static_cast<double>(span_ns)) / 100;
}

template <typename T>
T record_of(const std::byte* bytes) {
  T record;
  std::memcpy(&record, bytes, sizeof record);
  return record;
}

}  // namespace

LogIndex::LogIndex(const std::string& path) : trace_(path), columns_(log_columns(trace_)) {
  if (columns_.empty()) {
    throw McapError(path + ": has no servo frames; name a recording of a session");
  }
  for (const LogColumn& column : columns_) {
    Lanes& lanes = lanes_.emplace_back();
    lanes.servo.decoder = trace_.decoder(info_of(Topic<ServoFrame>{column.servo}));
    lanes.contact.decoder = trace_.decoder(info_of(Topic<ContactSet>{column.contact}));
    lanes.sim.decoder = trace_.decoder(info_of(Topic<SceneFrame>{column.sim}));
  }
  find_bounds();
}

bool LogIndex::refresh() {
  if (!trace_.mcap().refresh()) return false;
  find_bounds();
  return true;
}

/// Adds the chunks that may hold the topic.
void LogIndex::list_chunks(Lane& lane) {
  const std::vector<McapChunkIndex>& chunks = trace_.mcap().chunks();
  if (!lane.decoder) return;
  for (; lane.listed < chunks.size(); ++lane.listed) {
    const auto& index = chunks[lane.listed].index_offsets;
    if (!index.empty() && !index.contains(lane.decoder->channel())) continue;
    lane.chunks.push_back(lane.listed);
    lane.first_ns.push_back(kUnread);
  }
}

void LogIndex::find_bounds() {
  for (Lanes& lanes : lanes_) {
    for (Lane* lane : {&lanes.servo, &lanes.contact, &lanes.sim}) list_chunks(*lane);
  }
  Lane& lane = lanes_[0].servo;
  Place place{0, 0};
  if (lane.chunks.empty() || (first_in(lane, 0) == kNone && !step_on(lane, place))) return;
  int64_t t_ns = 0;
  // to the first frame in the first chunk that has any
  while (record_at(lane, place, t_ns) == nullptr && step_on(lane, place)) {
  }
  const std::byte* bytes = record_at(lane, place, t_ns);
  if (bytes == nullptr) return;
  const auto first = record_of<ServoFrame>(bytes);
  first_tick_ = first.tick;
  first_ns_ = t_ns;
  ServoFrame later = first;
  for (int i = 0; i < 100 && step_on(lane, place); ++i) {
    const auto next = record_of<ServoFrame>(record_at(lane, place, t_ns));
    if (next.tick <= later.tick) break;
    later = next;
  }
  rate_ = rate_of(later.t_ns - first.t_ns, later.tick - first.tick);
  last_tick_ = first_tick_;
  if (const auto last = last_until(lane, kNone - 1); last && record_at(lane, *last, t_ns)) {
    last_tick_ = tick_of(t_ns);
  }
}

int64_t LogIndex::time_of(uint64_t tick) const {
  const auto ticks = static_cast<double>(tick) - static_cast<double>(first_tick_);
  return first_ns_ + std::llround(ticks * 1e9 / rate_);
}

uint64_t LogIndex::tick_of(int64_t t_ns) const {
  const double ticks = std::round(1e-9 * static_cast<double>(t_ns - first_ns_) * rate_);
  return first_tick_ + static_cast<uint64_t>(std::max(ticks, 0.0));
}

const LogIndex::Chunk& LogIndex::load(size_t number) {
  const auto is_it = [&](const Chunk& chunk) { return chunk.number == number; };
  const auto found = std::ranges::find_if(loaded_, is_it);
  if (found != loaded_.end()) {
    loaded_.splice(loaded_.begin(), loaded_, found);
    return loaded_.front();
  }
  Chunk chunk;
  chunk.number = number;
  trace_.mcap().for_each_in(trace_.mcap().chunks()[number], [&](const McapMessage& message) {
    chunk.messages.push_back({message.channel, static_cast<int64_t>(message.publish_time_ns),
                              message, chunk.bytes.size(), message.data.size()});
    chunk.bytes.insert(chunk.bytes.end(), message.data.begin(), message.data.end());
  });
  for (Chunk::Message& one : chunk.messages) {
    one.message.data = std::span(chunk.bytes).subspan(one.offset, one.size);
  }
  loaded_.push_front(std::move(chunk));
  if (loaded_.size() > kMostLoaded) loaded_.pop_back();
  return loaded_.front();
}

/// Time of the first message of the topic in one of its chunks; kNone: it is not in there.
int64_t LogIndex::first_in(Lane& lane, size_t at) {
  int64_t& first_ns = lane.first_ns[at];
  if (first_ns != kUnread) return first_ns;
  first_ns = kNone;
  for (const Chunk::Message& one : load(lane.chunks[at]).messages) {
    if (one.channel != lane.decoder->channel()) continue;
    first_ns = one.t_ns;
    break;
  }
  return first_ns;
}

/// The record at a place; null if the message there is of another topic.
const std::byte* LogIndex::record_at(Lane& lane, const Place& place, int64_t& t_ns) {
  if (place.chunk >= lane.chunks.size()) return nullptr;
  const Chunk& chunk = load(lane.chunks[place.chunk]);
  if (place.message >= chunk.messages.size()) return nullptr;
  const Chunk::Message& one = chunk.messages[place.message];
  if (one.channel != lane.decoder->channel()) return nullptr;
  t_ns = one.t_ns;
  return lane.decoder->decode(one.message);
}

/// To the previous message of the topic; false if there is none.
bool LogIndex::step_back(Lane& lane, Place& place) {
  for (;;) {
    const std::vector<Chunk::Message>& messages = load(lane.chunks[place.chunk]).messages;
    while (place.message > 0) {
      if (messages[--place.message].channel == lane.decoder->channel()) return true;
    }
    if (place.chunk == 0) return false;
    --place.chunk;
    place.message = load(lane.chunks[place.chunk]).messages.size();
  }
}

/// To the next one.
bool LogIndex::step_on(Lane& lane, Place& place) {
  for (Place next{place.chunk, place.message + 1}; next.chunk < lane.chunks.size();
       next = {next.chunk + 1, 0}) {
    const std::vector<Chunk::Message>& messages = load(lane.chunks[next.chunk]).messages;
    for (; next.message < messages.size(); ++next.message) {
      if (messages[next.message].channel != lane.decoder->channel()) continue;
      place = next;
      return true;
    }
  }
  return false;
}

/// The last message of the topic that is not later; by bisection over the chunks.
std::optional<LogIndex::Place> LogIndex::last_until(Lane& lane, int64_t t_ns) {
  if (!lane.decoder) return std::nullopt;
  size_t low = 0, high = lane.chunks.size();
  std::optional<size_t> best;
  while (low < high) {
    const size_t middle = low + (high - low) / 2;
    size_t at = middle;
    while (at < high && first_in(lane, at) == kNone) ++at;
    if (at < high && first_in(lane, at) <= t_ns) {
      best = at;
      low = at + 1;
    } else {
      high = middle;
    }
  }
  if (!best) return std::nullopt;
  const std::vector<Chunk::Message>& messages = load(lane.chunks[*best]).messages;
  std::optional<Place> place;
  for (size_t i = 0; i < messages.size(); ++i) {
    if (messages[i].channel != lane.decoder->channel()) continue;
    if (messages[i].t_ns > t_ns) break;
    place = Place{*best, i};
  }
  return place;
}

std::optional<ServoFrame> LogIndex::frame_at(uint64_t tick, size_t column) {
  Lane& lane = lanes_.at(column).servo;
  const auto half_ns = static_cast<int64_t>(0.5e9 / rate_);
  const std::optional<Place> place = last_until(lane, time_of(tick) + half_ns);
  int64_t t_ns = 0;
  if (!place) return std::nullopt;
  return record_of<ServoFrame>(record_at(lane, *place, t_ns));
}

std::unique_ptr<ContactSet> LogIndex::contacts_at(const ServoFrame& frame, size_t column) {
  if ((frame.flags & kServoNoContactSet) != 0) return nullptr;
  Lane& lane = lanes_.at(column).contact;
  std::optional<Place> place = last_until(lane, frame.t_ns);
  if (!place) return nullptr;
  do {
    int64_t t_ns = 0;
    auto set = std::make_unique<ContactSet>(record_of<ContactSet>(record_at(lane, *place, t_ns)));
    if (set->seq == frame.contact_seq && set->answers_tick == frame.contact_tick) return set;
    const bool is_before = set->answers_tick < frame.contact_tick;
    if (is_before || t_ns < frame.t_ns - kOldest) return nullptr;
  } while (step_back(lane, *place));
  return nullptr;
}

std::optional<SceneFrame> LogIndex::scene_at(const ServoFrame& frame, size_t column) {
  Lane& lane = lanes_.at(column).sim;
  // sim may have published an instant that is a little ahead
  std::optional<Place> place = last_until(lane, frame.t_ns + kAhead);
  if (!place) return std::nullopt;
  do {
    int64_t t_ns = 0;
    const auto scene = record_of<SceneFrame>(record_at(lane, *place, t_ns));
    if (scene.seq == frame.scene_seq) return scene;
    if (scene.seq < frame.scene_seq) return std::nullopt;
  } while (step_back(lane, *place));
  return std::nullopt;
}

void LogIndex::for_each_frame(uint64_t from, uint64_t to, size_t column,
                              const std::function<void(const ServoFrame&)>& use) {
  Lane& lane = lanes_.at(column).servo;
  const auto half_ns = static_cast<int64_t>(0.5e9 / rate_);
  const int64_t begin_ns = time_of(from) - half_ns, end_ns = time_of(to) + half_ns;
  Place place = last_until(lane, begin_ns).value_or(Place{});
  if (lane.chunks.empty()) return;
  int64_t t_ns = 0;
  do {
    const std::byte* bytes = record_at(lane, place, t_ns);
    if (bytes == nullptr || t_ns < begin_ns) continue;
    if (t_ns > end_ns) return;
    use(record_of<ServoFrame>(bytes));
  } while (step_on(lane, place));
}

}  // namespace haptic
