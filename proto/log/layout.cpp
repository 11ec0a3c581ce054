// SPDX-License-Identifier: Apache-2.0
#include "proto/log/layout.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <map>
#include <stdexcept>
#include <utility>

namespace haptic {
namespace {

/// The value of a field in records whose layout lacks it.
struct Default {
  std::string_view schema, field;
  uint32_t value;
  std::string_view why;
};

// a new field of proto/wire/wire.h gets a row: without one older recordings are refused
constexpr std::array<Default, 27> kDefaults{{
    // since layout 11
    {"ServoFrame", "object_impulse_time_W", 0, "no object could be pushed away"},
    {"ServoFrame", "forgotten_impulse_W", 0, "no object could be pushed away"},
    {"ServoFrame", "impulses_since_ns", 0, "no object could be pushed away"},
    {"SceneFrame", "joints", 0, "there were no joints"},
    {"SceneFrame", "n_joints", 0, "there were no joints"},
    {"SceneFrame", "seen_t_ns", 0, "no object could be pushed away"},
    {"SceneFrame", "n_responses", 0, "no object could be pushed away"},
    {"SceneFrame", "responses", 0, "no object could be pushed away"},
    // since layout 9
    {"ServoFrame", "translational_stiffness", 0, "the coupling in force was not recorded"},
    {"ServoFrame", "rotational_stiffness", 0, "the coupling in force was not recorded"},
    {"ServoFrame", "X_command_B", 0, "no device was commanded a pose"},
    {"ServoFrame", "device.F_hand_B", 0, "no device measured the hand's wrench"},
    // since layout 8
    {"ControlFrame", "X_WT_intent", 0, "nobody led the hand"},
    {"ControlFrame", "intent_t_ns", 0, "nobody led the hand"},
    {"ControlFrame", "leading", 0, "nobody led the hand"},
    {"ControlFrame", "solver", 0, "as the session's file said"},
    // since layout 6; until 7 it was one for all objects
    {"ContactSet", "clearance", 0, "not known"},
    // since layout 5
    {"ContactSet", "contacts.stiffness", 0, "each contact was a plane"},
    {"ContactSet", "tool", 0, "the tool was a point"},
    {"ContactSet", "wrench_object", 0, "there was no linearised wrench"},
    // since layout 4
    {"ServoFrame", "held_back_W", 0, "there was no friction"},
    {"ServoFrame", "renderer", 0, "god-object3 was the only one"},
    {"ContactSet", "renderer", 0, "god-object3 was the only one"},
    // since layout 3
    {"ServoFrame", "fault", 0, "the reason of a fault was not recorded"},
    {"ControlFrame", "fault", 0, "faults ended with their servo"},
    {"ControlFrame", "armed", 1, "nothing had to be armed"},
    // since layout 2
    {"ContactSet", "reseeds", 0, "not counted"},
}};

/// The default of a field, or of the one that it is a part of; null: it has none.
const Default* default_of(std::string_view message, std::string_view path) {
  const auto row = std::find_if(kDefaults.begin(), kDefaults.end(), [&](const Default& d) {
    return d.schema == message && path.starts_with(d.field) &&
           (path.size() == d.field.size() || path[d.field.size()] == '.');
  });
  return row == kDefaults.end() ? nullptr : &*row;
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
    const Default* const row = default_of(schema_, path);
    if (row == nullptr) {
      throw std::runtime_error("it lacks '" + field.name + "', which has no default");
    }
    std::byte* const to = &out_.defaults[field.offset];
    const double real = row->value;
    const uint64_t whole = row->value;
    const bool is_real = field.type == "float64";
    std::memcpy(to, is_real ? static_cast<const void*>(&real) : &whole, size_of(field));
    const std::string value = std::to_string(row->value);
    note(std::string(row->field) + " (" + value + ": " + std::string(row->why) + ")");
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
  const Default* const row = default_of(message, field);
  return row != nullptr && row->value == 0;
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
