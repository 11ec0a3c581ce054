// SPDX-License-Identifier: Apache-2.0
#include "proto/ipc/control_socket.h"

#include <poll.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>

#include "proto/ipc/sessions.h"
#include "proto/math/assert.h"
#include "proto/os/message.h"

namespace haptic {
namespace {

constexpr size_t kMostPeers = 32;  // connected at once
constexpr uint64_t kDoor = 0;      // number of the listener; peers count from 1
constexpr const char* kSuffix = ".control";

std::string only_owner(uid_t owner) {
  return "error: only user " + std::to_string(owner) +
         " and root may control this session; watching is open to all";
}

bool send_line(int fd, const std::string& line) {
  return send(fd, line.data(), line.size(), MSG_DONTWAIT | MSG_NOSIGNAL) ==
         static_cast<ssize_t>(line.size());
}

uid_t owner_of(const std::string& path) {
  struct stat status {};
  return stat(path.c_str(), &status) == 0 ? status.st_uid : 0;
}

}  // namespace

// mode 0600 keeps other users out of the queue, where a flood would keep the owner out
ControlServer::ControlServer(const std::string& session)
    : listener_(runtime_folder() + "/" + session + kSuffix, 0600),
      epoll_(epoll_create1(EPOLL_CLOEXEC)) {
  wait_for_peers();
}

void ControlServer::wait_for_peers() {
  epoll_event event{EPOLLIN, {.u64 = kDoor}};
  if (epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, listener_.fd(), &event) != 0) {
    throw_errno("cannot wait for commands");
  }
}

void ControlServer::restore() {
  if (listener_.is_in_place()) return;
  listener_.listen_again();
  wait_for_peers();
}

void ControlServer::accept_peer() {
  std::optional<FileDescriptor> socket = listener_.accept();
  if (!socket || !socket->is_open()) return;
  const std::optional<uid_t> user = user_of(socket->get());
  if (user != 0 && user != geteuid()) {
    send_line(socket->get(), only_owner(geteuid()));
    return;
  }
  // the oldest of too many is stale
  if (peers_.size() >= kMostPeers) peers_.erase(peers_.begin());
  epoll_event event{EPOLLIN, {.u64 = next_peer_}};
  if (epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, socket->get(), &event) == 0) {
    peers_.emplace(next_peer_++, std::move(*socket));
  }
}

void ControlServer::serve(const Handler& handle) {
  std::array<epoll_event, kMostPeers + 1> events;
  const int n = epoll_wait(epoll_.get(), events.data(), static_cast<int>(events.size()), 0);
  for (int i = 0; i < n; ++i) {
    const uint64_t peer = events[static_cast<size_t>(i)].data.u64;
    if (peer == kDoor) {
      accept_peer();
    } else if (const auto found = peers_.find(peer); found != peers_.end()) {
      hear(peer, found->second.get(), handle);
    }
  }
}

void ControlServer::hear(uint64_t peer, int fd, const Handler& handle) {
  std::array<char, kLongestCommand> line;
  // true length: half a command could mean another one
  const ssize_t size = recv(fd, line.data(), line.size(), MSG_DONTWAIT | MSG_TRUNC);
  if (size > static_cast<ssize_t>(line.size())) {
    answer(peer, "error: a command has at most " + std::to_string(line.size()) + " bytes");
  } else if (size > 0) {
    handle(peer, std::string_view(line.data(), static_cast<size_t>(size)));
  } else if (size == 0 || (errno != EAGAIN && errno != EINTR)) {
    peers_.erase(peer);
  }
}

void ControlServer::answer(uint64_t peer, const std::string& line) {
  HAPTIC_ASSERT(peer != kDoor);
  const auto found = peers_.find(peer);
  if (found == peers_.end()) return;
  send_line(found->second.get(), line.substr(0, kLongestAnswer));
  peers_.erase(found);
}

namespace {

/// The answer to a question that everybody may ask, through the socket for watching.
std::string ask_as_watcher(const std::string& path, const std::string& line, int64_t patience_ns) {
  const FileDescriptor socket = unix_socket();
  if (!connect_to(socket, path, patience_ns)) throw HandoutError(path + ": does not answer");
  send_line(socket.get(), line);
  // announcements come first: they begin with a number, a text does not
  pollfd waiting{socket.get(), POLLIN, 0};
  std::string answer(kLongestAnswer, '\0');
  while (poll(&waiting, 1, static_cast<int>(patience_ns / 1'000'000)) > 0) {
    const ssize_t size = recv(socket.get(), answer.data(), answer.size(), 0);
    if (size <= 0) break;
    if (answer.front() > ' ') return answer.substr(0, static_cast<size_t>(size));
  }
  throw HandoutError(path + ": the session does not answer; others may watch it too often");
}

}  // namespace

std::string say_to_session(const std::string& session, const std::string& line,
                           int64_t patience_ns) {
  HAPTIC_ASSERT(patience_ns >= 0);
  // not through the socket for watching, whose queue others may have filled
  const std::string watching = find_session(session);
  const std::string name = std::filesystem::path(watching).stem().string();
  const FileDescriptor socket = unix_socket();
  const std::string path = std::filesystem::path(watching).replace_extension(kSuffix).string();
  if (!connect_to(socket, path, patience_ns)) {
    if (errno == EACCES && line.starts_with("status")) {
      return ask_as_watcher(watching, line, patience_ns);
    }
    if (errno == EACCES) return only_owner(owner_of(path));
    throw HandoutError("session '" + shown(name) + "' takes no commands (" + path + ": " +
                       std::strerror(errno) + "); see its log");
  }
  send_line(socket.get(), line);
  pollfd waiting{socket.get(), POLLIN, 0};
  if (poll(&waiting, 1, static_cast<int>(patience_ns / 1'000'000)) <= 0) {
    throw HandoutError("session '" + name + "' does not answer; see its log");
  }
  std::string answer(kLongestAnswer, '\0');
  ssize_t size = recv(socket.get(), answer.data(), answer.size(), 0);
  // refused before our line was read: the reason is queued behind this error
  if (size < 0 && errno == ECONNRESET) size = recv(socket.get(), answer.data(), answer.size(), 0);
  if (size <= 0) throw HandoutError("session '" + name + "' hung up");
  answer.resize(static_cast<size_t>(size));
  return answer;
}

}  // namespace haptic
