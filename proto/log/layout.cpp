// SPDX-License-Identifier: Apache-2.0
#include "proto/log/layout.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "proto/os/text.h"

namespace haptic {
namespace {

constexpr size_t kWord = 8;  // [bytes]

/// Where older layouts had what is now in a part. # stands for the index, #/2 and #%2 for two of a
/// table that had a row for each of two hands.
struct Moved {
  std::string_view record, now, then;
};
constexpr auto kMoved = std::to_array<Moved>({
    {"ServoFrame", "pushes[#].impulse_w", "object_impulse_w[#]"},
    {"ServoFrame", "pushes[#].impulse_time_w", "object_impulse_time_w[#]"},
    {"ContactSet", "objects[#].x_wo", "x_wo[#]"},
    {"ContactSet", "objects[#].clearance", "clearance[#]"},
    {"SceneFrame", "objects[#].x_wo", "x_wo[#]"},
    {"SceneFrame", "objects[#].v_wo", "v_wo[#]"},
    {"SceneFrame", "objects[#].t_ns", "t_ns"},
    {"SceneFrame", "seen[#].t_ns", "seen_t_ns[#%2]"},
    {"SceneFrame", "seen[#]", "responses[#/2].seen[#%2]"},
});

/// Clears the values that the record before had in use and this one has not.
void clear_behind(size_t n, size_t before, const RecordPart& part, std::vector<std::byte>& out) {
  const size_t end = std::min(before, part.most);
  if (n >= end) return;
  std::memset(&out[part.offset + kPartHeader + n * part.element], 0, (end - n) * part.element);
}

/// The first index of a path; none: it has none.
std::optional<uint32_t> index_in(std::string_view path) {
  const size_t bracket = path.find('[');
  if (bracket == path.npos) return {};
  const size_t begin = bracket + 1;
  return number_from<uint32_t>(path.substr(begin, path.find(']', begin) - begin));
}

/// The path of a field in older layouts; empty: it has not moved.
std::string path_then(std::string_view record, std::string_view path) {
  const std::optional<uint32_t> index = index_in(path);
  if (!index) return "";
  const auto filled = [&](std::string_view pattern) {
    const auto number = [](uint32_t n) { return std::to_string(n); };
    return replaced(
        std::string(pattern),
        {{"#/2", number(*index / 2)}, {"#%2", number(*index % 2)}, {"#", number(*index)}});
  };
  for (const Moved& moved : kMoved) {
    const std::string_view list = moved.now.substr(0, moved.now.find('#'));
    if (record != moved.record || !path.starts_with(list)) continue;
    const std::string now = filled(moved.now);
    if (path.starts_with(now)) return filled(moved.then) + std::string(path.substr(now.size()));
  }
  return "";
}

/// What a field of a record is where the layout lacks it. `field`: the path of what is new, of
/// which it may be a part.
struct Default {
  std::string field;
  const Since* since;
};

/// The default of the field at this path, without indices, or of the innermost one that it is a
/// part of; nothing: it has been there from the first layout on.
std::optional<Default> default_of(std::string_view record, std::string_view path) {
  std::optional<Default> innermost;
  const RecordRow* row = find_record(record);
  for (size_t begin = 0; row != nullptr && begin < path.size();) {
    const size_t end = std::min(path.find('.', begin), path.size());
    const auto field =
        std::ranges::find(row->fields, path.substr(begin, end - begin), &RecordField::name);
    if (field == row->fields.end()) break;
    if (field->since.layout > 1) innermost = {std::string(path.substr(0, end)), &field->since};
    row = find_record(field->type);
    begin = end + 1;
  }
  return innermost;
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
  Translator(std::string_view schema, const Fields& ours, const Fields& stored)
      : schema_(schema.substr(schema.rfind('/') + 1)) {
    for (const Field& field : stored) {
      if (!by_path_.emplace(lower_case(field.name), &field).second) {
        throw std::runtime_error("it has '" + field.name + "' twice");
      }
    }
    out_.defaults.resize(ours.bytes);
    out_.parts = ours.parts;
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
    std::string path = lower_case(ours.name);
    if (const Field* theirs = find(path)) return copy(*theirs, ours);
    // of a list that the file lacks each value is zero, as its first was
    if (zero_.contains(with_indices(path, ""))) return;
    if (const std::string then = path_then(schema_, path); !then.empty()) {
      path = then;
      if (const Field* theirs = find(path)) return copy(*theirs, ours);
    }
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
    const bool is_length = field.name.starts_with("n_") && find_part(field.name.substr(2));
    const std::string path = with_indices(is_length ? field.name.substr(2) : field.name, "");
    const std::optional<Default> known = default_of(schema_, path);
    if (!known) {
      throw std::runtime_error("it lacks '" + field.name + "', which has no default");
    }
    std::byte* const to = &out_.defaults[field.offset];
    const uint32_t stated = known->since->value;
    // a part is as long as its default says, and what is in it is zero
    const bool is_in_part = find_part(known->field) && !is_length;
    const uint64_t whole = is_in_part            ? 0
                           : stated == kOwnIndex ? index_in(field.name).value_or(0)
                                                 : stated;
    const auto real = static_cast<double>(whole);
    const bool is_real = field.type == "float64";
    std::memcpy(to, is_real ? static_cast<const void*>(&real) : &whole, size_of(field));
    const std::string value = stated == kOwnIndex ? "its index" : std::to_string(stated);
    note(known->field + " (" + value + ": " + std::string(known->since->why) + ")");
    if (is_in_part && index_in(field.name)) zero_.insert(with_indices(lower_case(field.name), ""));
  }

  bool find_part(std::string_view name) const {
    const RecordRow* row = find_record(schema_);
    return row != nullptr && std::ranges::any_of(row->fields, [&](const RecordField& field) {
             return field.is_part && field.name == name;
           });
  }

  /// Once for each field, however many numbers it has.
  void note(const std::string& lacking) {
    std::vector<std::string>& said = out_.lacking;
    if (std::find(said.begin(), said.end(), lacking) == said.end()) said.push_back(lacking);
  }

  std::string_view schema_;
  std::unordered_map<std::string, const Field*> by_path_;
  std::unordered_set<std::string> zero_;  // fields of lists, without their index
  Translation out_;
};

}  // namespace

bool is_new_as_zero(std::string_view message, std::string_view field) {
  const std::optional<Default> known = default_of(message, field);
  return known && known->since->value == 0;
}

Translation translate(std::string_view schema, const Fields& ours, const Fields& stored) {
  return Translator(schema, ours, stored).take();
}

void pack_message(std::span<const std::byte> record, std::span<const RecordPart> parts,
                  std::vector<std::byte>& out) {
  const size_t begin = out.size();
  const auto append = [&](const std::byte* from, size_t bytes) {
    out.insert(out.end(), from, from + bytes);
  };
  append(record.data(), parts.empty() ? record.size() : parts.front().offset);
  for (const RecordPart& part : parts) {
    const std::byte* from = &record[part.offset];
    uint32_t n;
    std::memcpy(&n, from, sizeof n);
    const auto in_use = static_cast<uint32_t>(std::min<size_t>(n, part.most));
    append(reinterpret_cast<const std::byte*>(&in_use), sizeof in_use);
    if (in_use == 0) continue;
    out.resize(begin + (out.size() - begin + kWord - 1) / kWord * kWord);
    append(from + kPartHeader, in_use * part.element);
  }
}

bool unpack_message(std::span<const std::byte> message, std::span<const RecordPart> parts,
                    size_t size, std::vector<std::byte>& out) {
  out.resize(size);
  const size_t fixed = parts.empty() ? size : parts.front().offset;
  size_t at = 0;
  const auto take = [&](size_t to, size_t bytes) {
    if (message.size() - at < bytes) return false;
    std::memcpy(&out[to], message.data() + at, bytes);
    at += bytes;
    return true;
  };
  if (!take(0, fixed)) return false;
  for (const RecordPart& part : parts) {
    uint32_t before, n;
    std::memcpy(&before, &out[part.offset], sizeof before);
    if (!take(part.offset, sizeof n)) return false;
    std::memcpy(&n, &out[part.offset], sizeof n);
    if (n > part.most) return false;
    clear_behind(n, before, part, out);
    if (n == 0) continue;
    at = (at + kWord - 1) / kWord * kWord;
    if (at > message.size() || !take(part.offset + kPartHeader, n * part.element)) return false;
  }
  return at == message.size();
}

void apply(const Translation& translation, const std::byte* record, std::vector<std::byte>& out) {
  out = translation.defaults;
  for (const Translation::Copy& copy : translation.copies) {
    std::memcpy(&out[copy.to], record + copy.from, copy.size);
  }
  for (const RecordPart& part : translation.parts) {
    uint32_t n;
    std::memcpy(&n, &out[part.offset], sizeof n);
    n = static_cast<uint32_t>(std::min<size_t>(n, part.most));
    std::memcpy(&out[part.offset], &n, sizeof n);
  }
}

}  // namespace haptic
