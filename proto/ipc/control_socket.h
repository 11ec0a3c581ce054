// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "proto/config/config.h"
#include "proto/ipc/unix_socket.h"
#include "proto/os/realtime.h"

/// The control socket: one line of text to `<runtime folder>/<session>.control`, one line back, or
/// the text of the session file. Only hapticd's own user and root can connect. Others may watch
/// (handout_server.h) without delaying a command. A Unix socket: nothing listens on a network.
namespace haptic {

/// Longest command [bytes].
inline constexpr size_t kLongestCommand = 8192;
/// Longest answer [bytes]: a session file and the line about a replay. Less than a socket's default
/// buffer.
inline constexpr size_t kLongestAnswer = kMostConfigText + sizeof(Path) + 64;
/// Begin answers to what was not done: the command was right, or it was a mistake of who sent it.
inline constexpr std::string_view kFailedAnswer = "error: ";
inline constexpr std::string_view kMistakeAnswer = "mistake: ";

/// The reason in an answer that refuses, without the word before it; none: the command was carried
/// out.
inline std::optional<std::string> refusal_in(std::string_view answer) {
  for (const std::string_view prefix : {kFailedAnswer, kMistakeAnswer}) {
    if (answer.starts_with(prefix)) return std::string(answer.substr(prefix.size()));
  }
  return std::nullopt;
}

/// hapticd's end. It has no thread and never blocks: a peer whose socket is full is dropped, and
/// the oldest if there are too many.
class ControlServer {
 public:
  /// Listens beside the session's socket; the session's lock must be held. Throws HandoutError.
  explicit ControlServer(const std::string& session);
  ControlServer(const ControlServer&) = delete;

  /// Readable when serve() has something to do.
  int poll_fd() const { return epoll_.get(); }

  /// Passes on each received line with its peer's number, which is never reused. The answer may
  /// come later.
  using Handler = std::function<void(uint64_t peer, std::string_view line)>;
  void serve(const Handler& handle);

  /// Answers a peer and hangs up; does nothing if it has left.
  void answer(uint64_t peer, const std::string& line);

  /// Listens again if its socket was removed. Throws HandoutError.
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

/// Sends one line to a running session (empty name: the only one) and waits for the answer. The
/// status can be asked by everybody: who may not control asks through the socket for watching.
/// Throws HandoutError: no such session, not allowed, no answer in time.
std::string say_to_session(const std::string& session, const std::string& line,
                           int64_t patience_ns = 5 * kNsPerSecond);

}  // namespace haptic
