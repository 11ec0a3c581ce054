// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "proto/ipc/unix_socket.h"
#include "proto/os/file_descriptor.h"

namespace haptic {

/// 128 random bits of the kernel as 32 hexadecimal digits. Throws MessageError.
std::string make_token();

/// A file that only its user can read, as one that holds the token; removed with its owner.
class PrivateFile {
 public:
  /// Replaces what is there. Throws MessageError.
  PrivateFile(std::string path, const std::string& text);
  ~PrivateFile();
  PrivateFile(const PrivateFile&) = delete;

 private:
  std::string path_;
  FileDescriptor file_;  // open, so that no other file gets its number when it is removed
  std::optional<FileIdentity> identity_;  // what is there later may be somebody else's
};

}  // namespace haptic
