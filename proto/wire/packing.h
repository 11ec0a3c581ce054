// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "proto/wire/parts.h"

namespace haptic {

/// How a record with parts (kParts) is packed: the words before the first part, then of each part
/// its number of values and these.
template <typename T>
struct Packing {
  static constexpr size_t kWords = sizeof(T) / 8;  // of a record that is full
  static constexpr size_t kFixedBytes = kParts<T>[0].offset;
  static constexpr size_t kLeastWords = kFixedBytes / 8 + kParts<T>.size();

  /// Parts are whole words, one behind the other, to the end of the record.
  static constexpr bool is_sound() {
    size_t end = kFixedBytes;
    for (const RecordPart& part : kParts<T>) {
      if (part.offset != end || part.offset % 8 != 0 || part.element % 8 != 0) return false;
      end += kPartHeader + part.most * part.element;
    }
    return end == sizeof(T);
  }

  /// The bytes of a part that begins here; none if it has more values than its record has room for.
  static std::optional<size_t> bytes_of(const RecordPart& part, const std::byte* begin) noexcept {
    uint32_t n;
    std::memcpy(&n, begin, sizeof n);
    if (n > part.most) return {};
    return kPartHeader + n * part.element;
  }

  /// Calls run(begin, length [bytes]) for each run of words of a record that is packed.
  template <typename Run>
  static void for_each_run(const T& value, const Run& run) noexcept {
    const auto* bytes = reinterpret_cast<const std::byte*>(&value);
    run(bytes, kFixedBytes);
    for (const RecordPart& part : kParts<T>) {
      const std::byte* begin = bytes + part.offset;
      run(begin, bytes_of(part, begin).value_or(kPartHeader + part.most * part.element));
    }
  }

  /// Copies the fields, and leaves the lists empty.
  static void unpack_fields(const std::byte* packed, T& out) noexcept {
    auto* bytes = reinterpret_cast<std::byte*>(&out);
    std::memcpy(bytes, packed, kFixedBytes);
    for (const RecordPart& part : kParts<T>) std::memset(bytes + part.offset, 0, kPartHeader);
  }

  /// Copies packed words to their places. False, with `out` as it was, where the numbers of values
  /// do not make that length.
  static bool unpack(const std::byte* packed, size_t n_words, T& out) noexcept {
    const std::byte* const end = packed + 8 * n_words;
    std::array<size_t, kParts<T>.size()> length;
    const std::byte* at = packed + kFixedBytes;
    for (size_t k = 0; k < length.size(); ++k) {
      if (end - at < static_cast<std::ptrdiff_t>(kPartHeader)) return false;
      const std::optional<size_t> bytes = bytes_of(kParts<T>[k], at);
      if (!bytes || static_cast<std::ptrdiff_t>(*bytes) > end - at) return false;
      length[k] = *bytes;
      at += *bytes;
    }
    if (at != end) return false;
    auto* bytes = reinterpret_cast<std::byte*>(&out);
    std::memcpy(bytes, packed, kFixedBytes);
    at = packed + kFixedBytes;
    for (size_t k = 0; k < length.size(); at += length[k++]) {
      std::memcpy(bytes + kParts<T>[k].offset, at, length[k]);
    }
    return true;
  }
};

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

/// Records with parts, one after the other in memory as a ring holds them.
template <typename T>
class PackedRecords {
 public:
  void push_back(const T& record) {
    begins_.push_back(words_.size());
    Packing<T>::for_each_run(record, [&](const std::byte* begin, size_t length) {
      const size_t at = words_.size();
      words_.resize(at + length / 8);
      std::memcpy(&words_[at], begin, length);
    });
  }

  size_t size() const { return begins_.size(); }
  bool empty() const { return begins_.empty(); }
  T operator[](size_t i) const {
    const size_t begin = begins_[i], end = i + 1 < size() ? begins_[i + 1] : words_.size();
    T record{};
    Packing<T>::unpack(reinterpret_cast<const std::byte*>(&words_[begin]), end - begin, record);
    return record;
  }
  T front() const { return (*this)[0]; }
  T back() const { return (*this)[size() - 1]; }

  /// Goes through the records, each by value.
  class Iterator {
   public:
    using value_type = T;
    using difference_type = std::ptrdiff_t;

    Iterator() = default;
    Iterator(const PackedRecords* records, size_t at) : records_(records), at_(at) {}
    T operator*() const { return (*records_)[at_]; }
    Iterator& operator++() {
      ++at_;
      return *this;
    }
    Iterator operator++(int) { return std::exchange(*this, {records_, at_ + 1}); }
    bool operator==(const Iterator&) const = default;

   private:
    const PackedRecords* records_ = nullptr;
    size_t at_ = 0;
  };
  Iterator begin() const { return {this, 0}; }
  Iterator end() const { return {this, size()}; }

  /// The record that has this number in a field that grows from record to record; none: there is
  /// none.
  template <typename Number>
  std::optional<T> find(Number T::*field, Number number) const {
    size_t first = 0, last = size();
    while (first < last) {
      const size_t middle = std::midpoint(first, last);
      (*this)[middle].*field < number ? first = middle + 1 : last = middle;
    }
    if (first == size()) return {};
    const T record = (*this)[first];
    return record.*field == number ? std::optional(record) : std::nullopt;
  }

 private:
  std::vector<uint64_t> words_;
  std::vector<size_t> begins_;
};

}  // namespace haptic
