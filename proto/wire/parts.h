// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "proto/wire/wire.h"

namespace haptic {

/// The place of a part (packed.h) in its record. It begins with the number of its values, a
/// uint32_t, and four bytes of zero.
struct RecordPart {
  size_t offset, element;  // [bytes]
  size_t most;             // values
};
inline constexpr size_t kPartHeader = 8;  // [bytes]

/// The parts of a record in the order of their bytes, the last of which is the record's end; none,
/// where the list has none.
template <typename T>
inline constexpr std::array<RecordPart, 0> kParts{};

namespace detail {

/// The rows of a record without the last, which ends a list that may be empty.
template <size_t kRows>
constexpr std::array<RecordPart, kRows - 1> parts_of_rows(const RecordPart (&rows)[kRows]) {
  std::array<RecordPart, kRows - 1> parts{};
  std::copy_n(rows, kRows - 1, parts.begin());
  return parts;
}

}  // namespace detail

#define RECORD(record, ...)                 \
  namespace detail {                        \
  constexpr auto parts_in(const record*) {  \
    using Record [[maybe_unused]] = record; \
    return parts_of_rows({
#define FIELD(...)
#define ARRAY(...)
#define PART(type, most, field, ...) {offsetof(Record, field), sizeof(type), most},
#define END(record) \
  {}                \
  });               \
  }                 \
  }                 \
  template <>       \
  inline constexpr auto kParts<record> = detail::parts_in(static_cast<const record*>(nullptr));
#include "proto/wire/records.def"

}  // namespace haptic
