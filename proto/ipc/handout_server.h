// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "proto/ipc/handout_message.h"
#include "proto/ipc/unix_socket.h"

/// How segments reach their readers. hapticd sends every client of a session's socket the
/// descriptor of each segment and eye file, and of each later generation. Its children are
/// connected by socket pairs; they alone may offer a segment, and contact the eye files. These and
/// what clients draw go to clients alone.
namespace haptic {

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
  /// Hands it out no longer: its writer has left. Who has it keeps it.
  void withdraw(SegmentId id) { segments_.erase(id); }

  /// Makes a socket pair for a child that may offer segment `id`, and what may_offer() adds, from
  /// `generation` on. Returns the child's end, which is closed on exec unless kept.
  FileDescriptor connect_child(SegmentId id, uint64_t generation);

  /// The child that may offer `id` from that generation on may offer `other` in its place.
  void become(SegmentId id, uint64_t generation, SegmentId other);

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
  std::map<SegmentId, Segment> segments_;  // the newest generation of each
  std::map<int, Peer> peers_;              // by descriptor
};

}  // namespace haptic
