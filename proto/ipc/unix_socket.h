// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>
#include <sys/un.h>

#include <cstdint>
#include <optional>
#include <string>

#include "proto/os/file_descriptor.h"
#include "proto/os/message.h"

namespace haptic {

/// One line: what is wrong and how to mend it.
struct HandoutError : MessageError {
  using MessageError::MessageError;
};

/// Throws HandoutError: what could not be done, and why by errno.
[[noreturn]] void throw_errno(const std::string& what);

/// A local non-blocking socket that preserves message boundaries; not open, with errno set, if the
/// kernel has none left.
FileDescriptor unix_socket();

/// The address of a path. Throws HandoutError if it exceeds the kernel's 107 characters.
sockaddr_un unix_address(const std::string& path);

/// Connects to the listener at the path; false with errno. EAGAIN: its accept queue is full, so
/// there is a listener.
bool connect_to(const FileDescriptor& socket, const std::string& path);

/// Waits up to patience_ns for a place in that queue.
bool connect_to(const FileDescriptor& socket, const std::string& path, int64_t patience_ns);

/// Identity of the file at a path; empty if there is none.
struct FileIdentity {
  dev_t device = 0;
  ino_t inode = 0;
  bool operator==(const FileIdentity&) const = default;
};
std::optional<FileIdentity> identity_of(const std::string& path);

/// A socket that listens at a path and replaces what was there; `mode` says who may connect. The
/// destructor removes the file if it is still its own.
class UnixListener {
 public:
  /// Throws HandoutError.
  UnixListener(std::string path, mode_t mode);
  ~UnixListener();
  UnixListener(const UnixListener&) = delete;
  UnixListener& operator=(const UnixListener&) = delete;

  int fd() const { return socket_.get(); }
  const std::string& path() const { return path_; }
  /// True if connections to the path reach this socket: the file may have been removed or replaced.
  bool is_in_place() const { return file_ && identity_of(path_) == file_; }
  /// Listens there again, with a new descriptor. Throws HandoutError.
  void listen_again();
  /// The next connection, which does not block; empty: none waits. One that is not open has ended,
  /// or was ended because the process has no descriptor left: unaccepted it would wake epoll for
  /// ever.
  std::optional<FileDescriptor> accept();

 private:
  std::string path_;
  mode_t mode_;
  FileDescriptor socket_;
  FileDescriptor spare_;  // closed for a moment when no other descriptor is left
  std::optional<FileIdentity> file_;
};

/// The user at the other end, as noted by the kernel when the socket was connected.
std::optional<uid_t> user_of(int socket);

}  // namespace haptic
