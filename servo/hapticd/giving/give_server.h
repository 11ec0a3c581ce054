// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "proto/config/config.h"
#include "proto/ipc/give_message.h"
#include "proto/ipc/handout_message.h"

namespace haptic {

/// Who gives under a name of the session file at present.
struct GiverSeat {
  bool is_taken = false;
  bool gives = false;  // its segment has been taken
  pid_t pid = -1;
  uid_t user = 0;
};

/// hapticd's end of the socket for clients that give (give_message.h). It has no thread and never
/// blocks. Only the owner of the session, root and the user of a [[client]] may give under its
/// name. A client has a second for each step of coming; a name takes new segments once a second, so
/// that nobody keeps the others busy with mapping.
class GiveServer {
 public:
  /// Listens beside the session's socket, whose lock must be held. Throws HandoutError.
  GiveServer(const std::string& session, const SessionConfig& config);
  GiveServer(const GiveServer&) = delete;

  /// Readable when serve() has something to do.
  int poll_fd() const { return epoll_.get(); }

  struct Handlers {
    std::function<void(const Announcement& offer, int fd)> on_offer;  // checked
    std::function<void(const std::string& line)> say;
  };
  void serve(int64_t t_ns, const Handlers& handlers);
  /// Listens again if its socket was removed. Throws HandoutError.
  void restore();

  const GiverSeat& seat(uint32_t client) const { return seats_[client]; }
  /// Generation of the segment of who gives under this name; 0: nobody does.
  uint64_t giving(uint32_t client) const { return seats_[client].gives ? generations_[client] : 0; }

 private:
  enum class Step { kConnected, kNamed, kGives, kDraws };
  struct Peer {
    FileDescriptor socket;
    Step step = Step::kConnected;
    int64_t since_ns = 0;  // of the step
    uint32_t client = 0;
    pid_t pid = -1;
    uid_t user = 0;
  };

  void wait_for_peers();
  bool accept_peer(int64_t t_ns);  // false: the queue is empty
  bool is_known(uid_t user) const;
  bool hear(Peer& peer, int64_t t_ns, const Handlers& handlers);  // false: it is to be dropped
  bool take_name(Peer& peer, int64_t t_ns);
  bool take_segment(Peer& peer, int64_t t_ns, const Handlers& handlers);
  void drop(uint64_t peer, const Handlers& handlers);
  std::string refusal_of(const Peer& peer, std::optional<uint32_t> client, std::string_view name,
                         int64_t t_ns) const;

  const SessionConfig& config_;
  UnixListener listener_;
  FileDescriptor epoll_;
  std::map<uint64_t, Peer> peers_;
  uint64_t next_peer_ = 1;
  std::array<GiverSeat, kMostClients> seats_{};
  std::array<uint64_t, kMostClients> generations_{};
  std::array<int64_t, kMostClients> told_ns_{};  // when the last generation was told
  std::array<std::optional<uid_t>, kMostClients> users_{};
};

}  // namespace haptic
