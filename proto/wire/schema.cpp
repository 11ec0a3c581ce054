// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/schema.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <stdexcept>

namespace haptic {
namespace {

struct Definition {
  std::string_view type;  // as in a field, without "/msg"
  std::string_view text;
};

constexpr std::array<Definition, 9> kDefinitions{{
    {"geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"},
    {"geometry_msgs/Pose",
     "geometry_msgs/Point position # [m]\ngeometry_msgs/Quaternion orientation\n"},
    {"geometry_msgs/Twist",
     "geometry_msgs/Vector3 linear # [m/s]\ngeometry_msgs/Vector3 angular # [rad/s]\n"},
    {"geometry_msgs/Wrench",
     "geometry_msgs/Vector3 force # [N]\ngeometry_msgs/Vector3 torque # [N·m]\n"},
    {"haptic_msgs/DeviceState", Schema<DeviceState>::text},
    {"haptic_msgs/Contact", Schema<Contact>::text},
    {"haptic_msgs/ToolBody", Schema<ToolBody>::text},
}};

/// Size of a ROS 2 primitive [bytes]; 0: not a primitive. XCDR1 aligns each to its own size.
constexpr size_t primitive_size(std::string_view type) {
  if (type == "float64" || type == "int64" || type == "uint64") return 8;
  if (type == "float32" || type == "int32" || type == "uint32") return 4;
  if (type == "int16" || type == "uint16") return 2;
  if (type == "int8" || type == "uint8" || type == "byte" || type == "bool") return 1;
  return 0;
}

constexpr std::string_view definition(std::string_view type) {
  for (const Definition& d : kDefinitions) {
    if (d.type == type) return d.text;
  }
  throw std::runtime_error("message type '" + std::string(type) + "' is not known");
}

/// One line of a definition: `type[count] name # [unit] comment`; count 0: not an array.
struct Line {
  std::string_view type, name, unit;
  size_t count = 0;
};

constexpr std::string_view take_word(std::string_view& rest) {
  const size_t begin = std::min(rest.find_first_not_of(" \t"), rest.size());
  const size_t end = std::min(rest.find_first_of(" \t", begin), rest.size());
  const std::string_view word = rest.substr(begin, end - begin);
  rest.remove_prefix(end);
  return word;
}

constexpr bool take_line(std::string_view& text, Line& line) {
  while (!text.empty()) {
    const size_t end = std::min(text.find('\n'), text.size());
    std::string_view code = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    line = {};
    const size_t hash = code.find('#');
    if (hash != std::string_view::npos) {
      const std::string_view comment = code.substr(hash + 1);
      if (comment.starts_with(" [")) line.unit = comment.substr(2, comment.find(']') - 2);
      code = code.substr(0, hash);
    }
    line.type = take_word(code);
    if (line.type.empty()) continue;
    line.name = take_word(code);
    const size_t bracket = line.type.find('[');
    if (bracket != std::string_view::npos) {
      for (const char c : line.type.substr(bracket + 1, line.type.size() - bracket - 2)) {
        // sequences and bounded arrays are no plain structs
        if (c < '0' || c > '9') throw std::runtime_error("only arrays of fixed size are supported");
        line.count = 10 * line.count + static_cast<size_t>(c - '0');
      }
      line.type = line.type.substr(0, bracket);
    }
    return true;
  }
  return false;
}

/// Offset of the field `stop` in a message that starts at `offset`; without `stop`, the end of the
/// message (XCDR1: each primitive aligned to its size from the start of the payload).
constexpr size_t cdr_end(std::string_view text, size_t offset, std::string_view stop = "") {
  for (Line line; take_line(text, line);) {
    if (line.name == stop) return offset;
    const size_t size = primitive_size(line.type);
    for (size_t i = 0; i < std::max<size_t>(line.count, 1); ++i) {
      offset = size > 0 ? (offset + size - 1) / size * size + size
                        : cdr_end(definition(line.type), offset);
    }
  }
  return offset;
}

template <typename T>
constexpr size_t size_as_text() {
  return cdr_end(Schema<T>::text, 0);
}
template <typename T>
constexpr size_t offset_as_text(std::string_view field) {
  return cdr_end(Schema<T>::text, 0, field);
}

static_assert(size_as_text<DeviceState>() == sizeof(DeviceState));
static_assert(size_as_text<Contact>() == sizeof(Contact));
static_assert(size_as_text<ToolBody>() == sizeof(ToolBody));
static_assert(size_as_text<ServoFrame>() == sizeof(ServoFrame));
static_assert(size_as_text<ContactSet>() == sizeof(ContactSet));
static_assert(size_as_text<SceneFrame>() == sizeof(SceneFrame));
static_assert(size_as_text<ControlFrame>() == sizeof(ControlFrame));
static_assert(size_as_text<Event>() == sizeof(Event));

// equal sizes do not reveal two swapped fields
static_assert(offset_as_text<DeviceState>("V_BH") == offsetof(DeviceState, V_BH));
static_assert(offset_as_text<DeviceState>("flags") == offsetof(DeviceState, flags));
static_assert(offset_as_text<Contact>("normal_O") == offsetof(Contact, normal_O));
static_assert(offset_as_text<Contact>("extent") == offsetof(Contact, extent));
static_assert(offset_as_text<Contact>("feature") == offsetof(Contact, feature));
static_assert(offset_as_text<ServoFrame>("t_ns") == offsetof(ServoFrame, t_ns));
static_assert(offset_as_text<ServoFrame>("realtime_ns") == offsetof(ServoFrame, realtime_ns));
static_assert(offset_as_text<ServoFrame>("device") == offsetof(ServoFrame, device));
static_assert(offset_as_text<ServoFrame>("X_WG") == offsetof(ServoFrame, X_WG));
static_assert(offset_as_text<ServoFrame>("X_WP") == offsetof(ServoFrame, X_WP));
static_assert(offset_as_text<ServoFrame>("F_coupling_W") == offsetof(ServoFrame, F_coupling_W));
static_assert(offset_as_text<ServoFrame>("F_device_B") == offsetof(ServoFrame, F_device_B));
static_assert(offset_as_text<ServoFrame>("depth") == offsetof(ServoFrame, depth));
static_assert(offset_as_text<ServoFrame>("wake_late_ns") == offsetof(ServoFrame, wake_late_ns));
static_assert(offset_as_text<ServoFrame>("busy_ns") == offsetof(ServoFrame, busy_ns));
static_assert(offset_as_text<ServoFrame>("flags") == offsetof(ServoFrame, flags));
static_assert(offset_as_text<ContactSet>("answers_tick") == offsetof(ContactSet, answers_tick));
static_assert(offset_as_text<ContactSet>("X_WG") == offsetof(ContactSet, X_WG));
static_assert(offset_as_text<ContactSet>("clearance") == offsetof(ContactSet, clearance));
static_assert(offset_as_text<ContactSet>("contacts") == offsetof(ContactSet, contacts));
static_assert(offset_as_text<ContactSet>("F0_W") == offsetof(ContactSet, F0_W));
static_assert(offset_as_text<ContactSet>("tool") == offsetof(ContactSet, tool));
static_assert(offset_as_text<ContactSet>("busy_ns") == offsetof(ContactSet, busy_ns));
static_assert(offset_as_text<ContactSet>("flags") == offsetof(ContactSet, flags));
static_assert(offset_as_text<SceneFrame>("V_WO") == offsetof(SceneFrame, V_WO));
static_assert(offset_as_text<SceneFrame>("busy_ns") == offsetof(SceneFrame, busy_ns));
static_assert(offset_as_text<ControlFrame>("rotational_damping") ==
              offsetof(ControlFrame, rotational_damping));
static_assert(offset_as_text<ControlFrame>("paused") == offsetof(ControlFrame, paused));
static_assert(offset_as_text<Event>("source") == offsetof(Event, source));

/// The `index`-th of comma-separated units; a single unit applies to every member.
std::string_view unit_of_member(std::string_view units, size_t index) {
  if (units.find(',') == std::string_view::npos) return units;
  for (; index > 0; --index) units.remove_prefix(std::min(units.find(',') + 2, units.size()));
  return units.substr(0, units.find(','));
}

/// Appends the numbers of one message; `units` are those the enclosing field states.
void flatten_into(std::string_view text, const std::string& prefix, std::string_view units,
                  std::vector<Field>& out, size_t& offset) {
  size_t member = 0;
  for (Line line; take_line(text, line); ++member) {
    // the enclosing field's units take precedence: an impulse is a Wrench, but not in newtons
    const std::string_view unit = units.empty() ? line.unit : unit_of_member(units, member);
    const size_t size = primitive_size(line.type);
    for (size_t i = 0; i < std::max<size_t>(line.count, 1); ++i) {
      std::string name = prefix + std::string(line.name);
      if (line.count > 0) name += "[" + std::to_string(i) + "]";
      if (size == 0) {
        flatten_into(definition(line.type), name + ".", unit, out, offset);
        continue;
      }
      offset = (offset + size - 1) / size * size;
      out.push_back({std::move(name), std::string(line.type), offset, std::string(unit)});
      offset += size;
    }
  }
}

/// Nested types of `text`, each once, in order of appearance.
void collect_types(std::string_view text, std::vector<std::string_view>& types) {
  for (Line line; take_line(text, line);) {
    if (primitive_size(line.type) > 0) continue;
    if (std::find(types.begin(), types.end(), line.type) != types.end()) continue;
    types.push_back(line.type);
    collect_types(definition(line.type), types);
  }
}

/// The definition with field names in lower case; types and comments unchanged.
std::string with_ros_names(std::string_view text) {
  std::string out(text);
  const char* begin = text.data();
  for (Line line; take_line(text, line);) {
    const size_t at = static_cast<size_t>(line.name.data() - begin);
    for (size_t i = at; i < at + line.name.size(); ++i) {
      out[i] = static_cast<char>(std::tolower(static_cast<unsigned char>(out[i])));
    }
  }
  return out;
}

}  // namespace

std::vector<Field> flatten(std::string_view text) {
  std::vector<Field> fields;
  size_t offset = 0;
  flatten_into(text, "", "", fields, offset);
  return fields;
}

std::string full_definition(std::string_view text) {
  std::string whole = with_ros_names(text);
  std::vector<std::string_view> types;
  collect_types(text, types);
  for (const std::string_view type : types) {
    whole += std::string(80, '=') + "\nMSG: ";
    whole += type;
    whole += '\n';
    whole += with_ros_names(definition(type));
  }
  return whole;
}

}  // namespace haptic
