// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "proto/ipc/handout_message.h"
#include "proto/ipc/ring_source.h"
#include "proto/ipc/unix_socket.h"

/// A client's end of the handout (handout_server.h).
namespace haptic {

namespace detail {

/// All generations of one kind of segment that a reader still needs.
struct Feed {
  SegmentSpec spec{};
  std::unique_ptr<Generation> before_first = std::make_unique<Generation>();
  std::vector<std::unique_ptr<Generation>> generations;  // attach thread
  std::vector<std::unique_ptr<ReaderMark>> readers;
};

}  // namespace detail

struct AttachOptions {
  bool lock_memory = false;  // mlock and prefault each segment
  int fifo_priority = 0;     // of the attach thread, if granted; 0: normal
  /// All run on the attach thread.
  // a segment cannot be read: one line. Without it, one of another version ends the connection,
  // with that line as refusal()
  std::function<void(const std::string&)> on_error = {};
  std::function<void(const Announcement&, FileDescriptor)> on_eye = {};  // an eye file; may throw
  std::function<void()> on_closed = {};  // hapticd is gone or dropped this client
};

/// Receives announcements on a thread of its own; maps and checks each segment and links it in
/// with one atomic store; frees a generation once all readers have left it. Make Sources
/// before start(), and do not use them after the Attachments are gone. A reader that stops reading
/// keeps its generations mapped, since losses are counted exactly.
class Attachments {
 public:
  /// Takes a connected socket.
  explicit Attachments(FileDescriptor socket, AttachOptions options = {});
  ~Attachments();
  Attachments(const Attachments&) = delete;

  template <typename Channels>
  Source<Channels> source(uint32_t hand = kFirstHand) {
    detail::Feed& feed = feed_of(segment_spec<Channels>(hand));
    return Source<Channels>(feed.before_first.get(), add_reader(feed));
  }

  /// Use: attachments.ring<&ServoChannels::frames>(Start::kNewest).
  template <auto kMember>
  RingSource<kMember> ring(Start start, uint32_t hand = kFirstHand) {
    return make_ring<kMember>(kMember, start, hand);
  }

  /// Starts the thread; make no more sources after this.
  void start();

  bool is_connected() const { return connected_.load(std::memory_order_acquire); }

  /// Why hapticd refused this client, one line; empty: it did not. Valid once is_connected() is
  /// false.
  const std::string& refusal() const { return refusal_; }

 private:
  template <auto kMember, typename Channels, typename RingType>
  RingSource<kMember> make_ring(RingType Channels::*, Start start, uint32_t hand) {
    return RingSource<kMember>(source<Channels>(hand), start);
  }
  detail::Feed& feed_of(const SegmentSpec& spec);
  detail::ReaderMark* add_reader(detail::Feed& feed);
  void run();
  bool receive();
  bool attach(const Announcement& announcement, FileDescriptor fd);
  void take_eye(const Announcement& announcement, FileDescriptor fd);
  bool free_retired();  // true: some are left

  FileDescriptor socket_;
  FileDescriptor stop_event_;
  AttachOptions options_;
  std::map<SegmentId, detail::Feed> feeds_;
  std::string refusal_;  // written before connected_ is cleared
  std::atomic<bool> connected_{true};
  std::thread thread_;
};

}  // namespace haptic
