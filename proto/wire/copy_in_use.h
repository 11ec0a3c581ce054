// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>

#include "proto/wire/packing.h"

namespace haptic {

/// Copies what is in use of a record with lists: a step that keeps a frame does not copy the room
/// for the largest scene.
template <typename T>
void copy_in_use(const T& from, T& to) noexcept {
  const auto* source = reinterpret_cast<const std::byte*>(&from);
  auto* target = reinterpret_cast<std::byte*>(&to);
  Packing<T>::for_each_run(from, [&](const std::byte* begin, size_t length) {
    std::memcpy(target + (begin - source), begin, length);
  });
}

}  // namespace haptic
