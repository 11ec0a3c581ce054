// SPDX-License-Identifier: Apache-2.0
#include "proto/log/layout.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>

namespace haptic {
namespace {

/// What a field of a record is where the layout lacks it. `field`: the path of what is new, of
/// which it may be a part.
struct Default {
  std::string field;
  const Since* since;
};

/// The default of the field at this path, without indices, or of the one that it is a part of;
/// nothing: it has been there from the first layout on.
std::optional<Default> default_of(std::string_view record, std::string_view path) {
  const RecordRow* row = find_record(record);
  for (size_t begin = 0; row != nullptr && begin < path.size();) {
    const size_t end = std::min(path.find('.', begin), path.size());
    const auto field =
        std::ranges::find(row->fields, path.substr(begin, end - begin), &RecordField::name);
    if (field == row->fields.end()) return {};
    if (field->since.layout > 1) return Default{std::string(path.substr(0, end)), &field->since};
    row = find_record(field->type);
    begin = end + 1;
  }
  return {};
}

/// The path with another text for each of its indices: "a[3].b" becomes "a.b" or "a[0].b".
std::string with_indices(std::string_view path, std::string_view index) {
  std::string out;
  while (!path.empty()) {
    const size_t begin = std::min(path.find('['), path.size());
    out += path.substr(0, begin);
    if (begin < path.size()) out += index;
    path.remove_prefix(begin < path.size() ? path.find(']') + 1 : begin);
  }
  return out;
}

/// Builds a translation field by field.
class Translator {
 public:
  Translator(std::string_view schema, const std::vector<Field>& ours, std::string_view stored)
      : schema_(schema.substr(schema.rfind('/') + 1)), theirs_(flatten_definition(stored)) {
    for (const Field& field : theirs_) {
      if (!by_path_.emplace(lower_case(field.name), &field).second) {
        throw std::runtime_error("it has '" + field.name + "' twice");
      }
    }
    out_.stored_size = size_of(theirs_);
    out_.defaults.resize(size_of(ours));
    for (const Field& field : ours) add(field);
  }
  Translation take() { return std::move(out_); }

 private:
  const Field* find(const std::string& path) const {
    const auto at = by_path_.find(path);
    return at == by_path_.end() ? nullptr : at->second;
  }

  /// The value that became an array: the path with one index left out.
  const Field* find_single(const std::string& path) const {
    for (size_t at = 0; (at = path.find('[', at)) != std::string::npos; ++at) {
      std::string shorter = path;
      shorter.erase(at, path.find(']', at) + 1 - at);
      if (const Field* found = find(shorter)) return found;
    }
    return nullptr;
  }

  void add(const Field& ours) {
    const std::string path = lower_case(ours.name);
    if (const Field* theirs = find(path)) return copy(*theirs, ours);
    if (const Field* theirs = find_single(path)) {
      note(with_indices(ours.name, "[]") + " (one value for all)");
      return copy(*theirs, ours);
    }
    // beyond the end of a shorter array
    if (find(with_indices(path, "[0]")) == nullptr) add_default(ours);
  }

  void copy(const Field& theirs, const Field& ours) {
    if (theirs.type != ours.type) {
      throw std::runtime_error("'" + ours.name + "' is a " + theirs.type + " there and a " +
                               ours.type + " here");
    }
    const size_t size = size_of(ours);
    if (!out_.copies.empty()) {
      Translation::Copy& last = out_.copies.back();
      if (last.from + last.size == theirs.offset && last.to + last.size == ours.offset) {
        last.size += size;
        return;
      }
    }
    out_.copies.push_back({theirs.offset, ours.offset, size});
  }

  void add_default(const Field& field) {
    const std::string path = with_indices(field.name, "");
    const std::optional<Default> known = default_of(schema_, path);
    if (!known) {
      throw std::runtime_error("it lacks '" + field.name + "', which has no default");
    }
    std::byte* const to = &out_.defaults[field.offset];
    const double real = known->since->value;
    const uint64_t whole = known->since->value;
    const bool is_real = field.type == "float64";
    std::memcpy(to, is_real ? static_cast<const void*>(&real) : &whole, size_of(field));
    note(known->field + " (" + std::to_string(whole) + ": " + std::string(known->since->why) + ")");
  }

  /// Once for each field, however many numbers it has.
  void note(const std::string& lacking) {
    std::vector<std::string>& said = out_.lacking;
    if (std::find(said.begin(), said.end(), lacking) == said.end()) said.push_back(lacking);
  }

  std::string_view schema_;
  std::vector<Field> theirs_;
  std::map<std::string, const Field*> by_path_;
  Translation out_;
};

}  // namespace

bool is_new_as_zero(std::string_view message, std::string_view field) {
  const std::optional<Default> known = default_of(message, field);
  return known && known->since->value == 0;
}

Translation translate(std::string_view schema, const std::vector<Field>& ours,
                      std::string_view stored) {
  return Translator(schema, ours, stored).take();
}

void apply(const Translation& translation, const std::byte* record, std::vector<std::byte>& out) {
  out = translation.defaults;
  for (const Translation::Copy& copy : translation.copies) {
    std::memcpy(&out[copy.to], record + copy.from, copy.size);
  }
}

}  // namespace haptic
