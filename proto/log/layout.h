// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "proto/wire/schema.h"

namespace haptic {

/// Converts records of a file with another layout to this program's. Numbers keep their names and
/// types. Fields that the file lacks get the default of proto/wire/records.def, with its reason;
/// fields that only the file has are left out.
struct Translation {
  struct Copy {
    size_t from, to, size;  // [bytes]
  };
  size_t stored_size = 0;           // of a record in the file [bytes]
  std::vector<std::byte> defaults;  // of a record here, where nothing is copied
  std::vector<Copy> copies;
  std::vector<std::string> lacking;  // "reseeds (0: not counted)"
};

/// A field is found by its path. One value becomes every element of an array; of an array of
/// another length the common part is copied, and the rest is zero. `schema` is the name of the
/// message, `stored` its definition in the file, which is not trusted. Throws std::runtime_error,
/// one line: the definition cannot be used, a type has changed, a field that has no default lacks.
Translation translate(std::string_view schema, const std::vector<Field>& ours,
                      std::string_view stored);

/// True if records of an older layout lack this field, by its path without indices, and it is then
/// zero.
bool is_new_as_zero(std::string_view message, std::string_view field);

/// `record` has stored_size bytes, `out` those of a record here.
void apply(const Translation& translation, const std::byte* record, std::vector<std::byte>& out);

}  // namespace haptic
