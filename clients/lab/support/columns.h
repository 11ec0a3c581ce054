// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "proto/os/message.h"

namespace haptic {

/// Filled up with blanks to so many characters, and one at least where it is longer.
inline std::string padded(const std::string& text, size_t width) {
  const size_t n = count_characters(text);
  return text + std::string(n < width ? width - n : width > 0, ' ');
}

}  // namespace haptic
