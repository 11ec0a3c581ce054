// SPDX-License-Identifier: Apache-2.0
#include "proto/unix_socket.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "proto/handout.h"

namespace haptic {
namespace {

constexpr int kBacklog = 16;

}  // namespace

FileDescriptor unix_socket() {
  return FileDescriptor(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
}

sockaddr_un unix_address(const std::string& path) {
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

bool listen_at(const FileDescriptor& socket, const std::string& path) {
  const sockaddr_un address = unix_address(path);
  if (!socket.is_open()) return false;
  unlink(path.c_str());
  return bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
         chmod(path.c_str(), 0666) == 0 && listen(socket.get(), kBacklog) == 0;
}

}  // namespace haptic
