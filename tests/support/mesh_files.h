// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstring>
#include <string>

#include "contact/shape/mesh/primitives.h"

namespace haptic::test {

inline std::string first_replaced(std::string text, const std::string& what,
                                  const std::string& with) {
  return text.replace(text.find(what), what.size(), with);
}

inline constexpr uint64_t kPlenty = uint64_t{4} << 30;  // of memory for reading a mesh [bytes]

// a soup as the bytes of a file, one function per format of the baker; text with all 17 digits

std::string as_off(const Soup& soup);
std::string as_obj(const Soup& soup);
std::string as_text_stl(const Soup& soup);
std::string as_binary_stl(const Soup& soup);
std::string as_text_ply(const Soup& soup);
std::string as_binary_ply(const Soup& soup);

/// Adds the bytes of a value as stored in memory.
template <class T>
void append(std::string& out, T value) {
  char bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  out.append(bytes, sizeof value);
}

}  // namespace haptic::test
