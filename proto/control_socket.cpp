// SPDX-License-Identifier: Apache-2.0
#include "proto/control_socket.h"

#include <poll.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <vector>

#include "proto/unix_socket.h"

namespace haptic {
namespace {

constexpr size_t kMostPeers = 32;
constexpr uint64_t kDoor = 0;  // the listener, among the numbers of peers
constexpr const char* kSuffix = ".control";

bool send_line(int fd, const std::string& line) {
  return send(fd, line.data(), line.size(), MSG_DONTWAIT | MSG_NOSIGNAL) ==
         static_cast<ssize_t>(line.size());
}

}  // namespace

ControlServer::ControlServer(const std::string& session)
    : path_(runtime_folder() + "/" + session + kSuffix), listener_(unix_socket()) {
  // anybody may knock, so that everybody is told why he is not let in
  if (!listen_at(listener_, path_)) {
    throw HandoutError("cannot listen on " + path_ + ": " + std::strerror(errno));
  }
  epoll_ = FileDescriptor(epoll_create1(EPOLL_CLOEXEC));
  epoll_event event{EPOLLIN, {.u64 = kDoor}};
  if (epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, listener_.get(), &event) != 0) {
    throw HandoutError(std::string("cannot wait for commands: ") + std::strerror(errno));
  }
}

ControlServer::~ControlServer() {
  unlink(path_.c_str());
}

bool ControlServer::is_allowed(int fd) const {
  ucred peer{};
  socklen_t size = sizeof peer;
  return getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0 &&
         (peer.uid == 0 || peer.uid == geteuid());
}

void ControlServer::accept_peer() {
  FileDescriptor socket(accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (!socket.is_open()) return;
  // at the door: who may not control must not keep others out either
  if (!is_allowed(socket.get())) {
    send_line(socket.get(), "error: only user " + std::to_string(geteuid()) +
                                " and root may control this session; watching is open to all");
    return;
  }
  // the oldest of too many has nothing to say any more
  if (peers_.size() >= kMostPeers) peers_.erase(peers_.begin());
  epoll_event event{EPOLLIN, {.u64 = next_peer_}};
  if (epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, socket.get(), &event) == 0) {
    peers_.emplace(next_peer_++, std::move(socket));
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
  const ssize_t size = recv(fd, line.data(), line.size(), MSG_DONTWAIT);
  if (size > 0) {
    handle(peer, std::string_view(line.data(), static_cast<size_t>(size)));
  } else if (size == 0 || (errno != EAGAIN && errno != EINTR)) {
    peers_.erase(peer);
  }
}

void ControlServer::answer(uint64_t peer, const std::string& line) {
  const auto found = peers_.find(peer);
  if (found == peers_.end()) return;
  send_line(found->second.get(), line.substr(0, kLongestCommand));
  peers_.erase(found);
}

std::string say_to_session(const std::string& session, const std::string& line,
                           int64_t patience_ns) {
  // the session's own socket says which folder it lives in, and that it runs
  const SessionPeer peer = peer_of(connect_session(session));
  const FileDescriptor socket = unix_socket();
  const std::string path = peer.folder + "/" + peer.session + kSuffix;
  if (!connect_to(socket, path)) {
    throw HandoutError("session '" + peer.session + "' takes no commands (" + path + ": " +
                       std::strerror(errno) + "); is it of an older hapticd?");
  }
  send_line(socket.get(), line);
  pollfd waiting{socket.get(), POLLIN, 0};
  if (poll(&waiting, 1, static_cast<int>(patience_ns / 1'000'000)) <= 0) {
    throw HandoutError("session '" + peer.session + "' does not answer; see its log");
  }
  std::string answer(kLongestCommand, '\0');
  ssize_t size = recv(socket.get(), answer.data(), answer.size(), 0);
  // refused at the door, before our line was read: the reason lies behind this error
  if (size < 0 && errno == ECONNRESET) size = recv(socket.get(), answer.data(), answer.size(), 0);
  if (size <= 0) throw HandoutError("session '" + peer.session + "' hung up");
  answer.resize(static_cast<size_t>(size));
  return answer;
}

}  // namespace haptic
