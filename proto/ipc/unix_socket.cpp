// SPDX-License-Identifier: Apache-2.0
#include "proto/ipc/unix_socket.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "proto/math/assert.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int kBacklog = SOMAXCONN;      // a flood must not fill it before connections are accepted
constexpr int64_t kRetryNs = 2'000'000;  // while the queue is full [ns]

FileDescriptor spare_descriptor() {
  return FileDescriptor(open("/dev/null", O_RDONLY | O_CLOEXEC));
}

}  // namespace

void throw_errno(const std::string& what) {
  throw HandoutError(what + ": " + std::strerror(errno));
}

FileDescriptor unix_socket() {
  return FileDescriptor(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
}

sockaddr_un unix_address(const std::string& path) {
  HAPTIC_ASSERT(!path.empty());
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) {
    throw HandoutError("path of the session's socket is too long: " + path +
                       "; set HAPTICD_RUNTIME_DIR to a shorter folder");
  }
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  return address;
}

bool connect_to(const FileDescriptor& socket, const std::string& path) {
  const sockaddr_un address = unix_address(path);
  return socket.is_open() &&
         connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
}

bool connect_to(const FileDescriptor& socket, const std::string& path, int64_t patience_ns) {
  HAPTIC_ASSERT(patience_ns >= 0);
  const int64_t give_up_ns = now_ns() + patience_ns;
  while (!connect_to(socket, path)) {
    if (errno != EAGAIN || now_ns() > give_up_ns) return false;
    sleep_until(now_ns() + kRetryNs);
  }
  return true;
}

std::optional<FileIdentity> identity_of(const std::string& path) {
  struct stat status {};
  if (lstat(path.c_str(), &status) != 0) return std::nullopt;
  return FileIdentity{status.st_dev, status.st_ino};
}

UnixListener::UnixListener(std::string path, mode_t mode)
    : path_(std::move(path)), mode_(mode), spare_(spare_descriptor()) {
  listen_again();
}

UnixListener::~UnixListener() {
  if (is_in_place()) unlink(path_.c_str());
}

void UnixListener::listen_again() {
  const sockaddr_un address = unix_address(path_);
  socket_ = unix_socket();
  unlink(path_.c_str());
  // nobody can connect before listen(), by which time the file's mode is set
  if (!socket_.is_open() ||
      bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      chmod(path_.c_str(), mode_) != 0 || listen(socket_.get(), kBacklog) != 0) {
    throw_errno("cannot listen on " + path_);
  }
  file_ = identity_of(path_);
}

std::optional<FileDescriptor> UnixListener::accept() {
  FileDescriptor peer(accept4(fd(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (peer.is_open() || errno == EINTR || errno == ECONNABORTED) return peer;
  if (errno != EMFILE && errno != ENFILE) return std::nullopt;
  spare_.reset();
  FileDescriptor(accept4(fd(), nullptr, nullptr, SOCK_CLOEXEC));
  spare_ = spare_descriptor();
  return peer;
}

std::optional<uid_t> user_of(int socket) {
  ucred peer{};
  socklen_t size = sizeof peer;
  if (getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0) return std::nullopt;
  return peer.uid;
}

}  // namespace haptic
