// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>
#include <sys/un.h>

#include <cstdint>
#include <optional>
#include <string>

#include "proto/os/file_descriptor.h"

namespace haptic {

/// A socket of this machine that keeps messages apart and blocks nobody; not open where the kernel
/// has none left, with errno set.
FileDescriptor unix_socket();

/// The address of a path. Throws HandoutError where the kernel's 107 characters do not hold it.
sockaddr_un unix_address(const std::string& path);

/// Whether the socket is connected to what listens at the path; errno says why not. EAGAIN: the
/// queue of those who wait to be accepted is full, so somebody does listen there.
bool connect_to(const FileDescriptor& socket, const std::string& path);

/// The same, but waits for a place in that queue for up to patience_ns.
bool connect_to(const FileDescriptor& socket, const std::string& path, int64_t patience_ns);

/// Which file lies under a name; nothing where there is none.
struct FileIdentity {
  dev_t device = 0;
  ino_t inode = 0;
  bool operator==(const FileIdentity&) const = default;
};
std::optional<FileIdentity> identity_of(const std::string& path);

/// A socket that listens at a path, in the place of what was left there; `mode` says who may
/// connect. At its end it removes the file where it is still its own.
class UnixListener {
 public:
  /// Throws HandoutError.
  UnixListener(std::string path, mode_t mode);
  ~UnixListener();
  UnixListener(const UnixListener&) = delete;
  UnixListener& operator=(const UnixListener&) = delete;

  int fd() const { return socket_.get(); }
  const std::string& path() const { return path_; }
  /// Whether who connects to the path comes here: the file may have been removed or replaced.
  bool is_in_place() const { return file_ && identity_of(path_) == file_; }
  /// Listens there again, with another descriptor. Throws HandoutError.
  void listen_again();

 private:
  std::string path_;
  mode_t mode_;
  FileDescriptor socket_;
  std::optional<FileIdentity> file_;
};

/// The user at the other end of a connected socket, as the kernel noted him when it was connected.
std::optional<uid_t> user_of(int socket);

}  // namespace haptic
