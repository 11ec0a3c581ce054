// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace haptic {

/// 128 random bits of the kernel as 32 hexadecimal digits. Throws MessageError.
std::string make_token();

/// A file with the token that only its user can read; removed with its owner.
class TokenFile {
 public:
  /// Replaces what is there. Throws MessageError.
  TokenFile(std::string path, const std::string& token);
  ~TokenFile();
  TokenFile(const TokenFile&) = delete;

 private:
  std::string path_;
};

}  // namespace haptic
