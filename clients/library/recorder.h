// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "clients/library/eyes.h"
#include "clients/library/standard_messages.h"
#include "clients/log/trace_writer.h"
#include "proto/ipc/attachments.h"
#include "proto/log/trace.h"

namespace haptic {

struct TopicCount {
  std::string_view topic;
  uint64_t recorded = 0;  // in the file, once finish() has returned
  // published while recording but not in the file: overwritten before they were read, or after a
  // write error; for /events this includes events that the recorder itself adds
  uint64_t lost = 0;
};

/// Drains every ring of a session into a recording. When a writer restarts, everything its
/// predecessor published is recorded first. Losses are counted exactly, each with a record on
/// /events. A chunk stays open for 0.25 s: that much is lost if the recorder is killed, with what
/// the disk has kept waiting, and nothing if any other process is.
///
///   Attachments attachments(connect_session(name));
///   Recorder recorder(attachments);            // before attachments.start()
///   attachments.start();
///   TraceWriter trace(path, metadata);
///   while (…) { recorder.drain(trace, now_ns()); sleep 10 ms; }
///   recorder.finish(trace);
class Recorder {
 public:
  /// `start`: whether frames already in the rings belong to the recording. The control state and
  /// the events always do.
  /// `standard_rate`: of the messages of StandardMessages that are written too [Hz]; 0: none.
  explicit Recorder(Attachments& attachments, Start start = Start::kNewest,
                    double standard_rate = 0);

  /// The meshes that the session hands out are written too, when they come and when they change:
  /// as attachments (clients/log/log_eyes.h), and as markers beside the StandardMessages.
  void follow(const EyeBook& eyes) { eyes_ = &eyes; }
  /// The pose X_WB of the device's base, for the StandardMessages.
  void set_base(const Pose& X_WB) { X_WB_ = X_WB; }
  /// Goes on with the session of another hapticd, after the last drain of the one before, whose
  /// attachments may end then: what it has published so far belongs to the recording too. A
  /// kSessionBack tells of the gap. Before attachments.start().
  void go_on(Attachments& attachments, TraceWriter& trace);

  /// Records everything new; `t_ns` is now (CLOCK_MONOTONIC). False after a write error, which
  /// trace.error() explains.
  bool drain(TraceWriter& trace, int64_t t_ns);

  /// Drains once more, adds the counts as metadata and closes the file. False after a write error;
  /// failure() then says in one line why and what was lost.
  bool finish(TraceWriter& trace, int64_t t_ns);
  const std::string& failure() const { return failure_; }

  /// One for each of kTopics, in that order, then those of other hands and of clients that have
  /// given.
  const std::vector<TopicCount>& counts() const { return counts_; }

  /// True if hapticd was stopped by command. Valid once the attachments are no longer connected.
  bool has_ended() const noexcept;

  /// Header of the newest servo's segment; null until one has been attached.
  const SegmentHeader* servo_header() noexcept;

 private:
  template <auto kFrames, auto kEvents>
  struct Feed {
    RingSource<kFrames> frames;
    RingSource<kEvents> events;
    uint64_t lost_frames = 0, lost_events = 0;  // already reported
  };

  /// Source of what a client gives, over all its segments.
  struct GivenFeed {
    RingSource<&ClientChannels::frames> frames;
    uint64_t lost = 0;  // already reported
  };

  struct Origin {
    SegmentId writer;
    uint64_t generation;
  };

  template <typename T>
  void tell_loss(TraceWriter& trace, const Topic<T>& topic, const Origin& origin, uint64_t lost,
                 uint64_t& told);
  template <auto kMember, typename T>
  void drain_ring(RingSource<kMember>& ring, const Topic<T>& topic, uint64_t& told,
                  SegmentId writer, TraceWriter& trace, uint64_t most);
  void drain_clients(TraceWriter& trace, uint64_t most);
  TopicCount& count_of(std::string_view topic, TraceWriter& trace);
  template <typename T>
  void write(TraceWriter& trace, const Topic<T>& topic, const T& record);
  void write_eyes(TraceWriter& trace);
  void write_eye_file(TraceWriter& trace, const EyeMesh& mesh);
  void count_what_is_there(const TraceWriter& trace);

  /// All rings of a session, frames from `start` on; control state and events change rarely, and
  /// those older than the recording belong to it too.
  struct Rings {
    struct OfHand {
      Feed<&ServoChannels::frames, &ServoChannels::events> servo;
      Feed<&ContactChannels::sets, &ContactChannels::events> contact;
      Feed<&ControlChannels::frames, &ControlChannels::events> control;
    };
    Rings(Attachments& attachments, Start start);
    Source<ServoChannels> newest_servo;  // of the first hand
    std::vector<OfHand> hands;           // by number, all there may be
    Feed<&SimChannels::frames, &SimChannels::events> sim;
    std::vector<GivenFeed> given;  // by client
  };

  Rings rings_;
  std::vector<TopicCount> counts_;
  int64_t last_servo_ns_ = 0;  // of the newest frame in the recording
  uint64_t last_tick_ = 0;
  int64_t realtime_offset_ns_ = 0;  // CLOCK_REALTIME − CLOCK_MONOTONIC
  int64_t chunk_begun_ns_ = 0;
  double standard_rate_;
  std::optional<StandardMessages> standard_;  // once there is a recording
  std::optional<SceneFrame> scene_;           // the newest
  std::string failure_;
  const EyeBook* eyes_ = nullptr;
  uint64_t eye_changes_ = 0;                                 // of the book, that are written
  std::map<uint32_t, std::vector<std::byte>> written_eyes_;  // by object: a restart brings the same
  std::optional<Pose> X_WB_;
};

}  // namespace haptic
