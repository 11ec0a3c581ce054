// SPDX-License-Identifier: Apache-2.0
// C: how a ring is opened, read and waited for.
#include <cmath>
#include <limits>

#include "clients/c/reader.h"
#include "proto/os/realtime.h"

using namespace haptic;

namespace {

constexpr int64_t kLookNs = 250'000;       // between two looks at a ring
constexpr int64_t kRetryNs = 100'000'000;  // between two attempts to connect again
constexpr double kLongestTimeout = 1e9;    // [s] beyond it: for ever

/// The instant at which the time is up.
int64_t end_of(double timeout) {
  if (std::isnan(timeout)) throw BadArgument("the timeout is no number");
  if (timeout < 0 || timeout > kLongestTimeout) return std::numeric_limits<int64_t>::max();
  return now_ns() + static_cast<int64_t>(timeout * 1e9);
}

/// A caller in C may give any number, which an enumeration of C++ may not hold.
template <typename Enum>
uint32_t number_of(const Enum& given) {
  static_assert(sizeof given == sizeof(uint32_t));
  uint32_t number;
  std::memcpy(&number, &given, sizeof number);
  return number;
}

/// HAPTICD_NOTHING: the time is up.
hapticd_result wait_for(Reader& reader, int64_t end_ns) {
  for (;;) {
    // asked before: what was published by then is read first
    const bool was_connected = reader.is_connected();
    if (reader.has_more()) return HAPTICD_OK;
    if (!was_connected) return reader.state();
    const int64_t t_ns = now_ns();
    if (t_ns >= end_ns) return HAPTICD_NOTHING;
    sleep_until(std::min(end_ns, t_ns + kLookNs));
  }
}

/// One record by `read`, which says whether there was one.
template <typename Read>
hapticd_result take(hapticd_frames* frames, const Read& read) {
  return with(frames, [&] {
    Reader& reader = *frames->reader;
    const bool was_connected = reader.is_connected();
    if (read(reader)) return HAPTICD_OK;
    return was_connected ? HAPTICD_NOTHING : reader.state();
  });
}

/// Null: hapticd is not back yet. A dying one may still take a connection. Throws a Failure: it
/// refuses.
std::unique_ptr<Reader> try_to_open(const hapticd_frames& frames) {
  try {
    std::unique_ptr<Reader> reader = frames.kind->open(frames.session, frames.hand, Start::kOldest);
    if (reader->is_connected()) return reader;
    if (reader->is_refused()) reader->state();
  } catch (const HandoutError&) {
    // nobody is there
  }
  return nullptr;
}

}  // namespace

hapticd_result hapticd_frames_open(hapticd_session* session, hapticd_ring ring, uint32_t hand,
                                   hapticd_start start, hapticd_frames** frames) {
  if (frames != nullptr) *frames = nullptr;
  return with(session, [&] {
    check_given(frames);
    const RingKind* kind = kind_of(number_of(ring));
    if (kind == nullptr) throw BadArgument("there is no such ring");
    if (number_of(start) > HAPTICD_FROM_OLDEST) throw BadArgument("there is no such start");
    const bool of_hand = ring == HAPTICD_SERVO || ring == HAPTICD_CONTACT;
    const uint32_t last_hand = of_hand ? kMostHands - 1 : 0;
    if (hand > last_hand) {
      throw BadArgument("hands of this ring are 0 to " + std::to_string(last_hand));
    }
    auto made = std::make_unique<hapticd_frames>();
    made->session = session->name;
    made->ring = ring;
    made->hand = hand;
    made->kind = kind;
    made->reader = kind->open(session->name, hand,
                              start == HAPTICD_FROM_NOW ? Start::kNewest : Start::kOldest);
    *frames = made.release();
    return HAPTICD_OK;
  });
}

void hapticd_frames_close(hapticd_frames* frames) {
  close_handle(frames);
}

const char* hapticd_frames_message(const hapticd_frames* frames) {
  return frames != nullptr ? frames->message.data() : last_message();
}

hapticd_result hapticd_frames_next(hapticd_frames* frames) {
  return take(frames, [](Reader& reader) { return reader.next(); });
}

hapticd_result hapticd_frames_latest(hapticd_frames* frames) {
  return take(frames, [](Reader& reader) { return reader.latest(); });
}

hapticd_result hapticd_frames_wait(hapticd_frames* frames, double timeout) {
  return with(frames, [&] { return wait_for(*frames->reader, end_of(timeout)); });
}

hapticd_result hapticd_frames_reconnect(hapticd_frames* frames, double timeout) {
  return with(frames, [&] {
    const int64_t end_ns = end_of(timeout);
    if (frames->reader->is_connected()) return HAPTICD_OK;
    for (;;) {
      if (std::unique_ptr<Reader> back = try_to_open(*frames)) {
        frames->lost_before += frames->reader->lost();
        frames->reader = std::move(back);
        return HAPTICD_OK;
      }
      const int64_t t_ns = now_ns();
      if (t_ns >= end_ns) return HAPTICD_NOTHING;
      sleep_until(std::min(end_ns, t_ns + kRetryNs));
    }
  });
}

uint64_t hapticd_frames_lost(const hapticd_frames* frames) {
  return frames != nullptr ? frames->lost_before + frames->reader->lost() : 0;
}
