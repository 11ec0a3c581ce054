// SPDX-License-Identifier: Apache-2.0
#include "clients/log/given_replay.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <ranges>

#include "proto/os/message.h"

namespace haptic {
namespace {

constexpr size_t kMostTicks = 4096;  // four seconds at 1 kHz: sim remembers as many
constexpr size_t kKeptChunks = 16;   // one for each topic that is read side by side
constexpr int64_t kClockNs =
    5'000'000;  // by which a client's clock may be behind, as sim grants it
constexpr uint64_t kUnknownTick = std::numeric_limits<uint64_t>::max();
constexpr int64_t kNever = std::numeric_limits<int64_t>::max();

/// The session file inside; none: it has none, or one that this version does not read.
std::optional<SessionConfig> recorded_session(const TraceReader& trace) {
  try {
    const std::string text = trace.mcap().metadata("recording", "config");
    if (!text.empty()) return parse_config(text, "session.toml");
  } catch (const ConfigError&) {
    // its clients are then taken by their numbers
  }
  return std::nullopt;
}

std::string moves_of(const SessionConfig& session, const ClientConfig& client) {
  std::string words;
  for (uint32_t i = 0; i < client.n_moves; ++i) {
    const uint32_t object = client.moves[i];
    words += (i > 0 ? ", " : "") + std::string("object ") + std::to_string(object) + " '" +
             shown(view(session.objects[object].name)) + "'";
  }
  return words.empty() ? "no object" : words;
}

/// The number in the present session of a client of the recording.
uint32_t client_of(const std::string& path, const std::optional<SessionConfig>& recorded,
                   uint32_t number, const SessionConfig& session) {
  constexpr const char* kRemedy =
      "; play it with the session file that it was recorded with, or --without-clients";
  const bool is_known = recorded && number < recorded->n_clients;
  const std::string name = is_known ? std::string(view(recorded->clients[number].name)) : "";
  for (uint32_t c = 0; c < session.n_clients; ++c) {
    if (is_known ? view(session.clients[c].name) != name : c != number) continue;
    const std::string now = moves_of(session, session.clients[c]);
    const std::string then = is_known ? moves_of(*recorded, recorded->clients[number]) : now;
    if (now == then) return c;
    throw McapError(path + ": client '" + shown(name) + "' moved " + then +
                    ", and in this session it may move " + now + kRemedy);
  }
  throw McapError(path + ": client " +
                  (is_known ? "'" + shown(name) + "'" : std::to_string(number)) +
                  " gave, and this session has no such [[client]]" + kRemedy);
}

int64_t first_sample(const TraceReader& trace) {
  TopicCursor cursor(trace, info_of(servo_topic(kFirstHand)));
  while (cursor.next()) {
    const ServoFrame frame = cursor.read<ServoFrame>();
    if ((frame.device.flags & kDeviceFresh) != 0) return frame.device.t_ns;
  }
  return 0;
}

}  // namespace

void GivenReplay::Ticks::add(uint64_t tick, int64_t t_ns) {
  // a servo that has begun anew counts anew
  if (!rows.empty() && (tick <= rows.back().tick || t_ns <= rows.back().t_ns)) rows.clear();
  rows.push_back({tick, t_ns});
  if (rows.size() > kMostTicks) rows.pop_front();
}

/// Interpolates between two ticks that are known, where the frame of this one was lost.
std::optional<int64_t> GivenReplay::Ticks::instant_of(uint64_t tick) const {
  const auto after = std::ranges::lower_bound(rows, tick, {}, &Row::tick);
  if (after == rows.end()) return std::nullopt;
  if (after->tick == tick) return after->t_ns;
  if (after == rows.begin()) return std::nullopt;
  const Row& before = *std::prev(after);
  const double share =
      static_cast<double>(tick - before.tick) / static_cast<double>(after->tick - before.tick);
  return before.t_ns + std::llround(share * static_cast<double>(after->t_ns - before.t_ns));
}

uint64_t GivenReplay::Ticks::nearest(int64_t t_ns) const {
  if (rows.empty()) return kUnknownTick;
  const auto after = std::ranges::lower_bound(rows, t_ns, {}, &Row::t_ns);
  if (after == rows.begin()) return after->tick;
  const Row& before = *std::prev(after);
  if (after == rows.end()) return before.tick;
  return t_ns - before.t_ns <= after->t_ns - t_ns ? before.tick : after->tick;
}

std::optional<int64_t> GivenReplay::Source::instant() {
  waits = waits || cursor.next();
  return waits ? std::optional(cursor.stamp().t_ns) : std::nullopt;
}

GivenReplay::GivenReplay(const std::string& path, const SessionConfig& session, double from)
    : trace_(path, kKeptChunks), control_{{trace_, info_of(kControlTopic)}} {
  const auto recorded = recorded_session(trace_);
  for (uint32_t number = 0; number < kMostClients; ++number) {
    Source frames{{trace_, info_of(given_topic(number))}};
    if (!frames.instant()) continue;
    clients_.push_back({std::move(frames), number, client_of(path, recorded, number, session)});
  }
  if (is_empty()) return;
  for (uint32_t hand = 0; hand < kMostHands; ++hand) {
    servos_.push_back({{trace_, info_of(servo_topic(hand))}});
  }
  first_ns_ = first_sample(trace_) + std::llround(from * 1e9);
}

void GivenReplay::begin(int64_t t_ns) {
  begin_ns_ = t_ns;
  for (Ticks& ticks : here_) ticks.rows.clear();
  for (Ticks& ticks : there_) ticks.rows.clear();
  const auto rewind = [](Source& source) {
    source.cursor.rewind();
    source.waits = false;
  };
  rewind(control_);
  for (Source& servo : servos_) rewind(servo);
  for (Recorded& client : clients_) {
    rewind(client.frames);
    // it leaves, and comes as it came
    client.wanted = 0;
  }
}

/// The instant in the present run; what a liar states may be anything, and wraps.
int64_t GivenReplay::moved(int64_t t_ns) const {
  return static_cast<int64_t>(static_cast<uint64_t>(t_ns) + static_cast<uint64_t>(begin_ns_) -
                              static_cast<uint64_t>(first_ns_));
}

/// A client that has come or left and was not told of yet.
std::optional<GivenAgain> GivenReplay::change() {
  for (Recorded& client : clients_) {
    if (!client.wanted || *client.wanted == client.generation) continue;
    // between two generations it is gone
    client.generation = client.generation != 0 ? 0 : *client.wanted;
    return GivenAgain{.client = client.client, .generation = client.generation};
  }
  return std::nullopt;
}

bool GivenReplay::next(int64_t t_ns, GivenAgain& out) {
  while (has_begun()) {
    if (const auto changed = change()) {
      out = *changed;
      return true;
    }
    const int64_t control_ns = control_.instant().value_or(kNever);
    const auto first = std::ranges::min_element(
        clients_, {}, [&](Recorded& c) { return c.frames.instant().value_or(kNever); });
    const int64_t frame_ns =
        first != clients_.end() ? first->frames.instant().value_or(kNever) : kNever;
    const int64_t due_ns = std::min(control_ns, frame_ns);
    if (due_ns == kNever || moved(due_ns) > t_ns) return false;
    if (control_ns <= frame_ns) {
      const ControlFrame control = control_.cursor.read<ControlFrame>();
      control_.waits = false;
      for (Recorded& client : clients_) client.wanted = control.giving[client.number];
      continue;
    }
    first->frames.waits = false;
    if (frame_ns < first_ns_ || first->generation == 0) continue;
    out = {first->client, first->generation, true, {}};
    out.frame = here(first->frames.cursor.read<GivenFrame>(), frame_ns);
    return true;
  }
  return false;
}

/// A frame that was made at recorded_ns, as if it were made now.
GivenFrame GivenReplay::here(const GivenFrame& frame, int64_t recorded_ns) {
  for (size_t hand = 0; hand < servos_.size(); ++hand) {
    Source& servo = servos_[hand];
    while (servo.instant().value_or(kNever) <= recorded_ns + kClockNs) {
      const ServoFrame tick = servo.cursor.read<ServoFrame>();
      there_[hand].add(tick.tick, tick.t_ns);
      servo.waits = false;
    }
  }
  GivenFrame out = frame;
  out.t_ns = moved(frame.t_ns);
  for (GivenMotion& motion : out.moves) {
    motion.t_ns = moved(motion.t_ns);
    for (size_t hand = 0; hand < motion.ticks.size(); ++hand) {
      uint64_t& tick = motion.ticks[hand];
      if (tick == 0) continue;
      const auto there_ns = there_[hand].instant_of(tick);
      tick = there_ns ? here_[hand].nearest(moved(*there_ns)) : kUnknownTick;
    }
  }
  return out;
}

}  // namespace haptic
