// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "proto/config/config.h"
#include "proto/log/trace.h"

/// Gives again what clients gave in a recording, without them.
///
///   inputs   of the recording: the frames of each client (/client0/given …), the instants at which
///            it came and left (ControlFrame::giving), and the instant of each tick of the servos;
///            of the present run: when the hand's first sample is played, and each servo frame
///   instants of the recording are t₁ − t₀ later here: t₀ is that of the hand's first sample which
///            is played, t₁ the deadline at which it is. All that a frame states is moved by that
///   ticks    a tick of the recording was at an instant; here it is that of the servo frame seen
///            so far which is nearest to the same instant. So neither skipped ticks nor another
///            rate matter: a frame says its pushes by half a period too many or too few at most
///   loop     next(t) gives what is due at t, in the order of the recording
///   stop     at the end of the recording
///   bound    memory holds a chunk for each topic and four seconds of ticks; a tick that the
///            recording does not know stays unknown, so that what was refused is refused again
namespace haptic {

/// A client comes (a generation, no frame), gives, or leaves (generation zero).
struct GivenAgain {
  uint32_t client = 0;      // in the present session
  uint64_t generation = 0;  // of its segment in the recording; zero: it is gone
  bool is_frame = false;
  GivenFrame frame{};  // as of the present run
};

class GivenReplay {
 public:
  /// Opens a recording whose hand is played from `from` [s] on. Throws McapError where a client
  /// that gave is not in the session, or may not move the same objects there.
  GivenReplay(const std::string& path, const SessionConfig& session, double from);
  GivenReplay(const GivenReplay&) = delete;

  /// No client has given anything.
  bool is_empty() const { return clients_.empty(); }

  /// The hand's first sample is played at this instant. Also again, when its servo begins anew.
  void begin(int64_t t_ns);
  bool has_begun() const { return begin_ns_ != 0; }
  /// A servo frame of the present run.
  void see(uint32_t hand, const ServoFrame& frame) { here_[hand].add(frame.tick, frame.t_ns); }
  /// The next that is due at t_ns or before; false: there is nothing yet.
  bool next(int64_t t_ns, GivenAgain& out);

 private:
  /// The instants of the last ticks of a servo.
  struct Ticks {
    struct Row {
      uint64_t tick;
      int64_t t_ns;
    };
    std::deque<Row> rows;
    void add(uint64_t tick, int64_t t_ns);
    std::optional<int64_t> instant_of(uint64_t tick) const;
    uint64_t nearest(int64_t t_ns) const;
  };
  /// A topic, and whether its cursor is at a record that is not used yet.
  struct Source {
    TopicCursor cursor;
    bool waits = false;
    std::optional<int64_t> instant();
  };
  struct Recorded {
    Source frames;
    uint32_t number;                      // in the recording
    uint32_t client;                      // in the present session
    uint64_t generation = 0;              // of the recording, now
    std::optional<uint64_t> wanted = {};  // that has begun to count and is not told yet
  };
  std::optional<GivenAgain> change();
  GivenFrame here(const GivenFrame& frame, int64_t recorded_ns);
  int64_t moved(int64_t t_ns) const;

  TraceReader trace_;
  std::vector<Recorded> clients_;
  Source control_;
  std::vector<Source> servos_;                  // by hand
  std::array<Ticks, kMostHands> there_, here_;  // in the recording, in the present run
  int64_t first_ns_ = 0;                        // of what is played, in the recording
  int64_t begin_ns_ = 0;                        // the same instant in the present run
};

}  // namespace haptic
