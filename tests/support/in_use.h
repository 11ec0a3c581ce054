// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "proto/wire/packing.h"

namespace haptic::test {

/// What is in use of a record with parts, as a ring holds it. All else of it may be anything.
template <typename T>
std::vector<std::byte> bytes_in_use(const T& record) {
  std::vector<std::byte> bytes;
  Packing<T>::for_each_run(record, [&](const std::byte* begin, size_t length) {
    bytes.insert(bytes.end(), begin, begin + length);
  });
  return bytes;
}

}  // namespace haptic::test
