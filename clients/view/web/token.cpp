// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/view/web/token.h"

#include <fcntl.h>
#include <sys/random.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "proto/os/file_descriptor.h"
#include "proto/os/message.h"
#include "proto/os/text.h"

namespace haptic {

std::string make_token() {
  std::array<unsigned char, 16> bits{};
  if (getrandom(bits.data(), bits.size(), 0) != static_cast<ssize_t>(bits.size())) {
    throw MessageError("no random token: the kernel gives no random numbers (" +
                       std::string(std::strerror(errno)) + ")");
  }
  std::string token;
  for (const unsigned char byte : bits) token += formatted("%02x", unsigned{byte});
  return token;
}

PrivateFile::PrivateFile(std::string path, const std::string& text) : path_(std::move(path)) {
  unlink(path_.c_str());
  file_ = FileDescriptor(
      open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600));
  if (!file_.is_open() ||
      write(file_.get(), text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
    throw MessageError(shown(path_) + ": the token cannot be written (" +
                       std::string(std::strerror(errno)) + "); choose a place with --token-file");
  }
  identity_ = identity_of(path_);
}

PrivateFile::~PrivateFile() {
  if (identity_ && identity_of(path_) == identity_) unlink(path_.c_str());
}

}  // namespace haptic
