// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "proto/ipc/handout_message.h"
#include "proto/ipc/segment.h"
#include "proto/ipc/unix_socket.h"
#include "proto/math/assert.h"
#include "proto/os/message.h"

/// How segments reach their readers. hapticd listens on `<runtime folder>/<session>.sock` and sends
/// every client the descriptor of each segment and eye file, and of each later generation. Its
/// children are connected by socket pairs; they alone may offer a segment, and contact the eye
/// files, which go to clients alone.
namespace haptic {

/// Folder of this user's sessions: $HAPTICD_RUNTIME_DIR, else $XDG_RUNTIME_DIR/hapticd, else
/// /run/hapticd (root), else /tmp/hapticd-<uid>.
std::string runtime_folder();

/// Names of the sessions this user can reach and that answer now.
std::vector<std::string> running_sessions();

/// hapticd's end: the session's lock and socket, its clients and its children. It has no thread and
/// never blocks: a peer whose socket is full is dropped. Watchers cannot keep others out:
/// connections are limited per user and in total, except for the server's own user and root, and
/// the last descriptors of the process are reserved for its children. A refused client is told why.
/// Eye files are sent a few at a time, to a client that has read what it was sent before: the
/// kernel limits the descriptors that wait in all sockets of a user together.
class HandoutServer {
 public:
  /// Takes the session's lock and opens its socket. Throws HandoutError: bad name, foreign folder,
  /// or the session runs already.
  explicit HandoutServer(const std::string& session);
  ~HandoutServer();
  HandoutServer(const HandoutServer&) = delete;

  /// Readable when serve() has something to do.
  int poll_fd() const { return epoll_.get(); }

  /// Accepts clients, takes offers of children and announces them to all, drops peers that hung up,
  /// and sends clients the eye files they still lack. `on_offer` gets each new segment once.
  using OfferHandler = std::function<void(const Announcement&, int fd)>;
  /// A client may ask one question instead of watching. It gets the answer, if there is one, and is
  /// dropped: questions cost no more than the connections that are limited anyway.
  using QuestionHandler = std::function<std::string(std::string_view)>;
  void serve(const OfferHandler& on_offer, const QuestionHandler& on_question = {});

  /// Announces a segment of hapticd's own. Takes a writer's descriptor, sends a read-only one.
  void announce(SegmentId id, uint64_t generation, const char* name, int fd);

  /// Makes a socket pair for a child that may offer segment `id`, and what may_offer() adds, from
  /// `generation` on. Returns the child's end, which is closed on exec unless kept.
  FileDescriptor connect_child(SegmentId id, uint64_t generation);

  /// Ignores whatever older children of that id still send: they are dead.
  void forget_children(SegmentId id, uint64_t before_generation);

  /// Restores lock and socket if they, or the runtime folder, were removed; returns whether they
  /// were. Throws HandoutError if another server has taken the name meanwhile.
  bool restore();

  size_t n_clients() const;  // without the children
  const std::string& socket_path() const { return listener_->path(); }

 private:
  struct Segment {
    Announcement announcement;
    FileDescriptor fd;
  };
  struct Peer {
    FileDescriptor socket;
    bool is_child = false;
    SegmentId owns{};  // of a child
    uint64_t generation = 0;
    uid_t user = 0;              // of a client
    std::set<SegmentId> owed{};  // eye files it has not been sent
  };
  void lock_session();
  bool has_lock() const;
  void wait_for_clients();
  bool accept_client();  // false: the queue is empty
  std::string refusal_of(uid_t user, int fd) const;
  bool add_peer(Peer peer);  // false: it was dropped at once
  bool receive_from(Peer& peer, const OfferHandler& on_offer, const QuestionHandler& on_question);
  bool store(const Announcement& announcement, FileDescriptor fd);
  void send_to_all(const Segment& segment);
  bool send_owed(Peer& peer);

  std::string session_, folder_, lock_path_;
  FileDescriptor lock_;
  std::optional<UnixListener> listener_;
  FileDescriptor epoll_;
  FileDescriptor spare_;                   // closed for a moment when no other descriptor is left
  std::map<SegmentId, Segment> segments_;  // the newest generation of each
  std::map<int, Peer> peers_;              // by descriptor
};

/// Path of the socket of a running session; empty name: the only one. Does not wait for a place in
/// its queue. Throws as connect_session.
std::string find_session(const std::string& session);

/// Connects to a running session; empty name: the only one. Throws HandoutError, which lists the
/// running sessions and says how to start one.
FileDescriptor connect_session(const std::string& session);

/// The other end of a connection to a session.
struct SessionPeer {
  std::string folder, session;
  pid_t hapticd = -1;
};
SessionPeer peer_of(const FileDescriptor& socket);

/// For children: gives its segment to hapticd. Throws HandoutError.
void offer_segment(int socket, SegmentId id, uint64_t generation, const char* name, int fd);

namespace detail {

/// One generation of a segment in the list a reader follows.
struct Generation {
  std::unique_ptr<SegmentMapping> mapping;  // null: before the first generation
  uint64_t serial = 0;                      // position in the list
  size_t touched = 0;                       // bytes whose pages the attach thread has read once
  std::atomic<Generation*> next{nullptr};   // set once, by the attach thread
};

/// Position of a reader; the attach thread frees only generations before all readers.
struct ReaderMark {
  std::atomic<uint64_t> serial{0};
};

/// All generations of one kind of segment that a reader still needs.
struct Feed {
  const SegmentSpec* spec = nullptr;
  std::unique_ptr<Generation> before_first = std::make_unique<Generation>();
  std::vector<std::unique_ptr<Generation>> generations;  // attach thread
  std::vector<std::unique_ptr<ReaderMark>> readers;
};

}  // namespace detail

/// A reader's path through the generations of a segment. Never locks, allocates, frees or enters
/// the kernel: one atomic load shows whether there is a newer generation.
template <typename Channels>
class Source {
 public:
  Source(detail::Generation* first, detail::ReaderMark* mark) : at_(first), mark_(mark) {}

  /// The rings being read; null before the first segment. Advances to the first generation by
  /// itself, later only by advance().
  const Channels* channels() noexcept {
    if (at_->mapping == nullptr) advance();
    return at_->mapping != nullptr ? &at_->mapping->template channels<Channels>() : nullptr;
  }

  /// Whether the writer was replaced, so that the present rings are final.
  bool has_newer() const noexcept { return at_->next.load(std::memory_order_acquire) != nullptr; }

  /// Moves to the next generation; the one before may then be unmapped. False: there is none.
  bool advance() noexcept {
    HAPTIC_ASSERT(at_ != nullptr && mark_ != nullptr);
    detail::Generation* next = at_->next.load(std::memory_order_acquire);
    if (next == nullptr) return false;
    at_ = next;
    mark_->serial.store(next->serial, std::memory_order_release);
    return true;
  }

  /// Generation of the rings being read; 0: none yet.
  uint64_t generation() const noexcept {
    return at_->mapping != nullptr ? at_->mapping->generation() : 0;
  }

  /// Heartbeat, state and rights of the writer; null before the first segment.
  const SegmentHeader* header() const noexcept {
    return at_->mapping != nullptr ? &at_->mapping->header() : nullptr;
  }

 private:
  detail::Generation* at_;
  detail::ReaderMark* mark_;
};

/// Where a reader starts in the segment it finds first.
enum class Start {
  kNewest,  // only what is published from now on
  kOldest,  // what the ring holds, less an eighth that the writer may soon overwrite
};

/// Next item of a ring whose writer is gone. Counts exactly what cannot be read: overwritten items,
/// and those that a killed writer was about to overwrite.
template <typename RingType>
bool read_final(const RingType& ring, Cursor& cursor, typename RingType::Item& out) noexcept {
  const uint64_t end = ring.published(), from = std::max(cursor.next, ring.oldest(end));
  cursor.lost += from - cursor.next;
  cursor.next = from;
  while (cursor.next < end) {
    if (ring.read(cursor.next++, out)) return true;
    ++cursor.lost;
  }
  return false;
}

template <auto kMember>
class RingSource;

/// One ring of a segment, read across restarts of its writer: what a dead writer published is read
/// before its successor's first item, and every item not delivered is counted. For one reader
/// thread; same guarantees as Source. Use: RingSource<&ServoChannels::frames>.
template <typename Channels, typename RingType, RingType Channels::*kMember>
class RingSource<kMember> {
 public:
  using Item = typename RingType::Item;

  RingSource(Source<Channels> source, Start start) : source_(source), start_(start) {}

  /// Next item in order; false: nothing new.
  bool next(Item& out) noexcept {
    for (;;) {
      if (!find_ring()) return false;
      // asked before reading: what was published by then is final
      const bool ended = source_.has_newer();
      if (ended ? read_final(*ring_, cursor_, out) : read_next(*ring_, cursor_, out)) {
        item_generation_ = generation();
        return true;
      }
      if (!ended) return false;
      leave_ring();
    }
  }

  /// Newest item of the newest writer that has published one; false: nothing newer than the last
  /// one delivered. Items passed over do not count as lost.
  bool latest(Item& out) noexcept {
    bool found = false;
    while (find_ring()) {
      const bool ended = source_.has_newer();
      if (read_newest(out, ended)) {
        item_generation_ = generation();
        found = true;
      }
      if (!ended) break;
      leave_ring();
    }
    return found;
  }

  /// A few microseconds before latest(), which then finds the newest item in the cache.
  void prefetch_newest() const noexcept {
    if (ring_ != nullptr) ring_->prefetch_newest();
  }

  /// Items published since the start that next() could not deliver.
  uint64_t lost() const noexcept { return lost_ + cursor_.lost; }
  /// Generation of the writer being read; 0: none yet.
  uint64_t generation() const noexcept { return source_.generation(); }
  /// Generation of the writer of the last delivered item; 0: none yet.
  uint64_t item_generation() const noexcept { return item_generation_; }
  const SegmentHeader* header() const noexcept { return source_.header(); }

 private:
  bool find_ring() noexcept {
    if (ring_ != nullptr) return true;
    const Channels* channels = source_.channels();
    if (channels == nullptr) return false;
    ring_ = &(channels->*kMember);
    cursor_ = {};
    if (is_first_) cursor_.next = first_item();
    is_first_ = false;
    return true;
  }

  void leave_ring() noexcept {
    HAPTIC_ASSERT(ring_ != nullptr);
    lost_ += cursor_.lost;
    cursor_ = {};
    ring_ = nullptr;
    source_.advance();
  }

  uint64_t first_item() const noexcept {
    constexpr uint64_t kReach = RingType::kCapacity - RingType::kCapacity / 8;
    const uint64_t end = ring_->published(), oldest = ring_->oldest(end);
    if (start_ == Start::kNewest) return end;
    // a ring of short and long items may hold fewer than its slots
    const uint64_t safe = oldest > 0 ? oldest + (end - oldest) / 8 : 0;
    return std::max(end - std::min(end, kReach), safe);
  }

  bool read_newest(Item& out, bool ended) noexcept {
    HAPTIC_ASSERT(ring_ != nullptr);
    // the second attempt is needed only if the writer overran the ring during the copy
    for (int attempt = 0; attempt < 2; ++attempt) {
      const uint64_t end = ring_->published();
      if (end <= cursor_.next) return false;
      if (ring_->read(end - 1, out)) {
        cursor_.next = end;
        return true;
      }
      if (ended) break;
    }
    return false;
  }

  Source<Channels> source_;
  Start start_;
  const RingType* ring_ = nullptr;
  Cursor cursor_;
  uint64_t lost_ = 0;
  uint64_t item_generation_ = 0;
  bool is_first_ = true;
};

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
  Source<Channels> source() {
    detail::Feed& feed = feed_of(kSegmentSpec<Channels>);
    return Source<Channels>(feed.before_first.get(), add_reader(feed));
  }

  /// Use: attachments.ring<&ServoChannels::frames>(Start::kNewest).
  template <auto kMember>
  RingSource<kMember> ring(Start start) {
    return make_ring<kMember>(kMember, start);
  }

  /// Starts the thread; make no more sources after this.
  void start();

  bool is_connected() const { return connected_.load(std::memory_order_acquire); }

  /// Why hapticd refused this client, one line; empty: it did not. Valid once is_connected() is
  /// false.
  const std::string& refusal() const { return refusal_; }

 private:
  template <auto kMember, typename Channels, typename RingType>
  RingSource<kMember> make_ring(RingType Channels::*, Start start) {
    return RingSource<kMember>(source<Channels>(), start);
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
