// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <new>
#include <span>
#include <type_traits>

#include "proto/math/assert.h"

namespace haptic {

/// Part of a record: a list of at most kMost values, which lie in the record itself. The places
/// behind the last value are not initialised, so that a record of hundreds of places costs what it
/// holds. Whatever its memory holds, size() is at most kMost.
template <typename T, size_t kMost>
class Packed {
  static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= 8 && sizeof(T) % 8 == 0);

 public:
  using value_type = T;

  Packed() {}  // NOLINT(modernize-use-equals-default): Packed{} would then zero all places

  static constexpr size_t capacity() { return kMost; }
  size_t size() const { return std::min<size_t>(size_, kMost); }
  bool empty() const { return size() == 0; }
  bool full() const { return size() == kMost; }

  T* data() { return std::launder(reinterpret_cast<T*>(places_.data())); }
  const T* data() const { return std::launder(reinterpret_cast<const T*>(places_.data())); }
  T* begin() { return data(); }
  T* end() { return data() + size(); }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size(); }

  T& operator[](size_t i) {
    HAPTIC_ASSERT(i < size());
    return data()[i];
  }
  const T& operator[](size_t i) const {
    HAPTIC_ASSERT(i < size());
    return data()[i];
  }
  T& back() { return (*this)[size() - 1]; }
  const T& back() const { return (*this)[size() - 1]; }

  /// New values are T{}.
  void resize(size_t n) {
    HAPTIC_ASSERT(n <= kMost);
    for (size_t i = size(); i < n; ++i) new (data() + i) T{};
    size_ = static_cast<uint32_t>(n);
  }
  void clear() { size_ = 0; }
  void push_back(const T& value) {
    HAPTIC_ASSERT(!full());
    new (data() + size()) T(value);
    ++size_;
  }
  void assign(std::span<const T> values) {
    HAPTIC_ASSERT(values.size() <= kMost);
    std::copy(values.begin(), values.end(), data());
    size_ = static_cast<uint32_t>(values.size());
  }

 private:
  uint32_t size_ = 0;
  uint32_t reserved_ = 0;
  alignas(8) std::array<std::byte, kMost * sizeof(T)> places_;
};

}  // namespace haptic
