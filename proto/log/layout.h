// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "proto/wire/schema.h"

namespace haptic {

/// A message of a recording, or of ROS 2, and its struct in memory. What is before the first part
/// is the same in both; a part is a sequence in the message: the number of its values, and these,
/// aligned to eight bytes from where the message begins. Appends to `out`.
void pack_message(std::span<const std::byte> record, std::span<const RecordPart> parts,
                  std::vector<std::byte>& out);
/// `size`: of the struct [bytes]. False: the message is not one of it. Places that
/// are not in use are zero where `out` was empty or this function's.
bool unpack_message(std::span<const std::byte> message, std::span<const RecordPart> parts,
                    size_t size, std::vector<std::byte>& out);

/// Converts records of a file with another layout to this program's. Numbers keep their names and
/// types. Fields that the file lacks get the default of proto/wire/records.def, with its reason;
/// fields that only the file has are left out. Some had another name: an array of each field became
/// a part with a record of them.
struct Translation {
  struct Copy {
    size_t from, to, size;  // [bytes]
  };
  std::vector<std::byte> defaults;  // of a record here, where nothing is copied
  std::vector<Copy> copies;
  std::vector<RecordPart> parts;  // of a record here, none of which becomes longer than it may be
  std::vector<std::string> lacking;  // "reseeds (0: not counted)"
};

/// A field is found by its path. One value becomes every element of an array; of an array of
/// another length the common part is copied, and the rest is zero. `schema` is the name of the
/// message. Throws std::runtime_error, one line: a type has changed, a field that has no default
/// lacks.
Translation translate(std::string_view schema, const Fields& ours, const Fields& stored);

/// True if records of an older layout lack this field, by its path without indices, and it is then
/// zero.
bool is_new_as_zero(std::string_view message, std::string_view field);

/// Both are structs in memory.
void apply(const Translation& translation, const std::byte* record, std::vector<std::byte>& out);

}  // namespace haptic
