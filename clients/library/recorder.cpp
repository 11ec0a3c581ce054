// SPDX-License-Identifier: Apache-2.0
#include "clients/library/recorder.h"

#include <algorithm>
#include <type_traits>
#include <utility>

#include "clients/library/client.h"
#include "clients/log/log_eyes.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int64_t kChunkPeriodNs = kNsPerSecond / 4;  // a killed recorder loses its open chunk
constexpr uint64_t kMostPerDrain = 4096;              // records per ring, the size of the largest
// Likewise of a client, three times what 1 kHz brings in 10 ms: one that floods its ring loses its
// own frames, and nobody else's.
constexpr uint64_t kMostGivenPerDrain = 32;
constexpr int64_t kOldestGivenNs = 10 * kNsPerSecond;  // a ring of 256 frames at 25 Hz

int64_t time_of(const auto& record) {
  return record.t_ns;
}
int64_t time_of(const ContactSet& set) {
  return set.answers_t_ns;
}
/// The instant that a client states may be anything; the frame itself is written as it is.
int64_t time_of(const GivenFrame& frame) {
  const int64_t t_ns = now_ns();
  return std::clamp(frame.t_ns, t_ns - kOldestGivenNs, t_ns);
}

}  // namespace

Recorder::Rings::Rings(Attachments& attachments, Start start)
    : newest_servo(attachments.source<ServoChannels>()),
      sim{attachments.ring<&SimChannels::frames>(start),
          attachments.ring<&SimChannels::events>(Start::kOldest)} {
  for (uint32_t hand = 0; hand < kMostHands; ++hand) {
    hands.push_back({{attachments.ring<&ServoChannels::frames>(start, hand),
                      attachments.ring<&ServoChannels::events>(Start::kOldest, hand)},
                     {attachments.ring<&ContactChannels::sets>(start, hand),
                      attachments.ring<&ContactChannels::events>(Start::kOldest, hand)},
                     {attachments.ring<&ControlChannels::frames>(Start::kOldest, hand),
                      attachments.ring<&ControlChannels::events>(Start::kOldest, hand)}});
  }
  for (uint32_t client = 0; client < kMostClients; ++client) {
    given.push_back({attachments.ring<&ClientChannels::frames>(start, client)});
  }
}

Recorder::Recorder(Attachments& attachments, Start start, double standard_rate)
    : rings_(attachments, start), standard_rate_(standard_rate) {
  for (const TopicInfo& topic : kTopics) counts_.push_back({topic.name});
}

/// A client, and a hand behind the first, has topics from its first frame on.
TopicCount& Recorder::count_of(std::string_view topic, TraceWriter& trace) {
  const auto known = std::ranges::find(counts_, topic, &TopicCount::topic);
  if (known != counts_.end()) return *known;
  trace.add_topic(*find_topic(topic));
  return counts_.emplace_back(TopicCount{topic});
}

template <typename T>
void Recorder::write(TraceWriter& trace, const Topic<T>& topic, const T& record) {
  TopicCount& count = count_of(topic.name, trace);
  const int64_t t_ns = time_of(record);
  Stamp stamp{t_ns, t_ns + realtime_offset_ns_, count.recorded + count.lost};
  if constexpr (std::is_same_v<T, ServoFrame>) stamp.realtime_ns = record.realtime_ns;
  ++(trace.write(topic, record, stamp) ? count.recorded : count.lost);
  if constexpr (std::is_same_v<T, SceneFrame>) scene_ = record;
  if constexpr (std::is_same_v<T, ServoFrame>) {
    if (topic.name != servo_topic(kFirstHand).name) return;
    last_servo_ns_ = record.t_ns;
    last_tick_ = record.tick;
    standard_->add(record, scene_ ? &*scene_ : nullptr);
  }
}

template <typename T>
void Recorder::tell_loss(TraceWriter& trace, const Topic<T>& topic, const Origin& origin,
                         uint64_t lost, uint64_t& told) {
  if (lost == told) return;
  count_of(topic.name, trace).lost += lost - told;
  write(trace, kEventTopic,
        Event{now_ns(),
              static_cast<uint32_t>(EventCode::kRecordsLost),
              static_cast<uint32_t>(origin.writer),
              {static_cast<double>(lost - told), static_cast<double>(lost),
               static_cast<double>(origin.generation), std::is_same_v<T, Event> ? 1.0 : 0.0, 0}});
  told = lost;
}

template <auto kMember, typename T>
void Recorder::drain_ring(RingSource<kMember>& ring, const Topic<T>& topic, uint64_t& told,
                          SegmentId writer, TraceWriter& trace, uint64_t most) {
  T record{};
  // bounded, so that a writer faster than the disk cannot starve the other rings
  for (uint64_t n = 0; n < most && ring.next(record); ++n) {
    tell_loss(trace, topic, {writer, ring.generation()}, ring.lost(), told);
    write(trace, topic, record);
  }
  // a ring may end with a loss and no record after it
  tell_loss(trace, topic, {writer, ring.generation()}, ring.lost(), told);
}

void Recorder::go_on(Attachments& attachments, TraceWriter& trace) {
  const double gap = 1e-9 * static_cast<double>(now_ns() - last_servo_ns_);
  drain_clients(trace, kMostPerDrain);
  rings_ = Rings(attachments, Start::kOldest);
  scene_.reset();
  write(trace, kEventTopic,
        Event{now_ns(),
              static_cast<uint32_t>(EventCode::kSessionBack),
              static_cast<uint32_t>(SegmentId::kControl),
              {last_servo_ns_ > 0 ? gap : 0, static_cast<double>(last_tick_), 0, 0, 0}});
}

bool Recorder::has_ended() const noexcept {
  return haptic::has_ended(rings_.hands[kFirstHand].control.frames.header());
}

const SegmentHeader* Recorder::servo_header() noexcept {
  while (rings_.newest_servo.advance()) {
  }
  return rings_.newest_servo.header();
}

bool Recorder::drain(TraceWriter& trace, int64_t t_ns) {
  realtime_offset_ns_ = realtime_now_ns() - now_ns();
  if (!standard_) {
    standard_.emplace(trace, standard_rate_);
    if (X_WB_) standard_->set_base(*X_WB_);
  }
  if (eyes_ != nullptr) write_eyes(trace);
  servo_header();  // unmaps old generations
  const auto drain_feed = [&](auto& feed, const auto& topic, SegmentId writer) {
    drain_ring(feed.frames, topic, feed.lost_frames, writer, trace, kMostPerDrain);
    drain_ring(feed.events, kEventTopic, feed.lost_events, writer, trace, kMostPerDrain);
  };
  const auto each_hand = [&](const auto& drain) {
    for (uint32_t hand = 0; hand < kMostHands; ++hand) drain(rings_.hands[hand], hand);
  };
  each_hand([&](Rings::OfHand& rings, uint32_t hand) {
    drain_feed(rings.control, control_topic(hand), control_segment(hand));
  });
  drain_feed(rings_.sim, kSimTopic, SimChannels::kId);
  each_hand([&](Rings::OfHand& rings, uint32_t hand) {
    drain_feed(rings.contact, contact_topic(hand), contact_segment(hand));
    drain_feed(rings.servo, servo_topic(hand), servo_segment(hand));
  });
  drain_clients(trace, kMostGivenPerDrain);
  if (chunk_begun_ns_ == 0) chunk_begun_ns_ = t_ns;
  if (t_ns - chunk_begun_ns_ >= kChunkPeriodNs) {
    chunk_begun_ns_ = t_ns;
    trace.close_chunk();
  }
  return trace.error().empty();
}

void Recorder::drain_clients(TraceWriter& trace, uint64_t most) {
  for (uint32_t client = 0; client < rings_.given.size(); ++client) {
    GivenFeed& feed = rings_.given[client];
    drain_ring(feed.frames, given_topic(client), feed.lost, ClientChannels::id(client), trace,
               most);
  }
}

void Recorder::write_eyes(TraceWriter& trace) {
  const Eyes eyes = eyes_->eyes();
  if (std::exchange(eye_changes_, eyes.changes) == eyes.changes) return;
  const auto write_all = [&](const auto& meshes) {
    for (const auto& mesh : meshes) {
      if (mesh) write_eye_file(trace, *mesh);
    }
  };
  write_all(eyes.tools);
  write_all(eyes.objects);
}

void Recorder::write_eye_file(TraceWriter& trace, const EyeMesh& mesh) {
  std::vector<std::byte> bytes = write_eye(mesh);
  std::vector<std::byte>& before = written_eyes_[mesh.object];
  if (bytes == before) return;
  const Stamp stamp{now_ns(), realtime_now_ns(), written_eyes_.size()};
  trace.add_attachment(eye_attachment(mesh.object), kEyeMediaType, stamp.realtime_ns, bytes);
  before = std::move(bytes);
  std::vector<Vec3> vertices;
  for (const EyePoint& p : mesh.vertices) vertices.push_back({p[0], p[1], p[2]});
  const bool is_tool = is_eye_of_tool(mesh.object);
  standard_->add_mesh({.frame = is_tool ? "tool" : "object_" + std::to_string(mesh.object),
                       .name = mesh.name,
                       .colour = {mesh.colour.r, mesh.colour.g, mesh.colour.b, mesh.colour.a},
                       .vertices = vertices,
                       .triangles = mesh.triangles},
                      stamp);
}

bool Recorder::finish(TraceWriter& trace, int64_t t_ns) {
  drain(trace, t_ns);
  drain_clients(trace, kMostPerDrain);
  McapMetadata counts;
  for (const TopicCount& count : counts_) {
    counts[std::string(count.topic) + " recorded"] = std::to_string(count.recorded);
    counts[std::string(count.topic) + " lost"] = std::to_string(count.lost);
  }
  trace.add_metadata("counts", counts);
  if (const SegmentHeader* servo = servo_header()) {
    trace.add_metadata("realtime", {{"servo", realtime_of(*servo).explain()}});
  }
  if (trace.close()) return true;
  count_what_is_there(trace);
  return false;
}

/// A file that ended with an error holds the chunks before it: all that came after them counts as
/// lost.
void Recorder::count_what_is_there(const TraceWriter& trace) {
  failure_ = trace.error();
  const char* separator = "; lost: ";
  for (TopicCount& count : counts_) {
    const uint64_t there = trace.written(count.topic);
    count.lost += count.recorded - there;
    count.recorded = there;
    if (count.lost == 0) continue;
    failure_ += separator + std::to_string(count.lost) + " of " + std::string(count.topic);
    separator = ", ";
  }
}

}  // namespace haptic
