// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "proto/config/config_text.h"
#include "proto/ipc/handout.h"

/// How people tell a session what to do: one line of text to `<runtime folder>/<session>.control`,
/// one line back, or the text of the session file. Only hapticd's own user and root can connect;
/// anybody else may watch (see handout.h), and how many do cannot delay a command. A Unix socket:
/// nothing listens on a network.
namespace haptic {

/// Longest line that is said to a session [bytes].
inline constexpr size_t kLongestCommand = 8192;
/// Longest answer [bytes]: the text of a session file, and the line that tells of a replay. Below
/// what a socket holds unless told otherwise.
inline constexpr size_t kLongestAnswer = kMostConfigText + sizeof(Path) + 64;

/// hapticd's end. It owns no thread and never blocks: a peer whose socket is full is dropped, and
/// of too many peers the oldest.
class ControlServer {
 public:
  /// Listens beside the session's socket, whose lock is held. Throws HandoutError.
  explicit ControlServer(const std::string& session);
  ControlServer(const ControlServer&) = delete;

  /// Readable when serve() has something to do.
  int poll_fd() const { return epoll_.get(); }

  /// Hands over each line that came, with the number of its peer, which no other ever gets. The
  /// answer may come later.
  using Handler = std::function<void(uint64_t peer, std::string_view line)>;
  void serve(const Handler& handle);

  /// Answers a peer and hangs up; nothing where it has left.
  void answer(uint64_t peer, const std::string& line);

  /// Listens again where somebody has removed its socket. Throws HandoutError.
  void restore();

 private:
  void wait_for_peers();
  void accept_peer();
  void hear(uint64_t peer, int fd, const Handler& handle);

  UnixListener listener_;
  FileDescriptor epoll_;
  std::map<uint64_t, FileDescriptor> peers_;
  uint64_t next_peer_ = 1;
};

/// Says one line to a running session (an empty name means the only one there is) and waits for the
/// answer. Throws HandoutError: no such session, not allowed, no answer in time.
std::string say_to_session(const std::string& session, const std::string& line,
                           int64_t patience_ns = 5 * kNsPerSecond);

}  // namespace haptic
