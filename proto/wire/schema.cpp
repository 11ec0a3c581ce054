// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/schema.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <functional>
#include <map>
#include <stdexcept>
#include <utility>

namespace haptic {
namespace {

// Bounds for the schema of a file; the largest of ours, SceneFrame, takes two thirds of them.
constexpr size_t kMostText = size_t{64} << 10;      // of a definition [bytes]
constexpr size_t kMostFlattened = size_t{1} << 20;  // read while a message is flattened [bytes]
constexpr size_t kMostFields = size_t{1} << 14;     // numbers of a message
constexpr size_t kMostTypes = 64;                   // nested ones
constexpr int kMostDepth = 8;                       // of types in types
constexpr size_t kLongestName = 64;

struct Definition {
  std::string_view type;  // as in a field, without "/msg"
  std::string_view text;
};

constexpr auto kDefinitions = std::to_array<Definition>({
    {"geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"},
    {"geometry_msgs/Pose",
     "geometry_msgs/Point position # [m]\ngeometry_msgs/Quaternion orientation\n"},
    {"geometry_msgs/Twist",
     "geometry_msgs/Vector3 linear # [m/s]\ngeometry_msgs/Vector3 angular # [rad/s]\n"},
    {"geometry_msgs/Wrench",
     "geometry_msgs/Vector3 force # [N]\ngeometry_msgs/Vector3 torque # [N·m]\n"},
#define RECORD(record, ...) {Schema<record>::type, Schema<record>::text},
#define FIELD(...)
#define ARRAY(...)
#define PART(...)
#define END(...)
#include "proto/wire/records.def"
});

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

/// One line of a definition: `type[count] name # [unit] comment`; count 0: not an array. Of a
/// bounded sequence, `type[<=count]`, it is the bound.
struct Line {
  std::string_view type, name, unit;
  size_t count = 0;
  bool is_part = false;
};

constexpr std::string_view take_word(std::string_view& rest) {
  const size_t begin = std::min(rest.find_first_not_of(" \t"), rest.size());
  const size_t end = std::min(rest.find_first_of(" \t", begin), rest.size());
  const std::string_view word = rest.substr(begin, end - begin);
  rest.remove_prefix(end);
  return word;
}

/// The count of `type[count]` or `type[<=count]`, from the bracket on; 0: neither.
constexpr size_t count_of(std::string_view brackets) {
  if (brackets.empty()) return 0;
  size_t count = 0;
  const bool ends = brackets.size() > 2 && brackets.back() == ']';
  brackets = brackets.substr(1, ends ? brackets.size() - 2 : 0);
  if (brackets.starts_with("<=")) brackets.remove_prefix(2);
  for (const char c : brackets) {
    count = c >= '0' && c <= '9' ? 10 * count + static_cast<size_t>(c - '0') : kMostFields + 1;
    if (count > kMostFields) break;
  }
  if (count == 0 || count > kMostFields) {
    throw std::runtime_error("only arrays and sequences of up to 16384 values are supported");
  }
  return count;
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
    const size_t bracket = std::min(line.type.find('['), line.type.size());
    line.count = count_of(line.type.substr(bracket));
    line.is_part = line.type.substr(bracket).starts_with("[<=");
    line.type = line.type.substr(0, bracket);
    return true;
  }
  return false;
}

constexpr size_t aligned(size_t offset, size_t size) {
  return (offset + size - 1) / size * size;
}

/// Offset of the field `stop` in a message that starts at `offset`; without `stop`, the end of the
/// message (XCDR1: each primitive aligned to its size from the start of the payload), with each
/// sequence as long as it may be.
constexpr size_t cdr_end(std::string_view text, size_t offset, std::string_view stop = "") {
  for (Line line; take_line(text, line);) {
    if (line.name == stop) return offset;
    const size_t size = primitive_size(line.type);
    if (line.is_part) {
      const size_t element = size > 0 ? size : cdr_end(definition(line.type), 0);
      offset = aligned(offset, 8) + kPartHeader + line.count * element;
      continue;
    }
    for (size_t i = 0; i < std::max<size_t>(line.count, 1); ++i) {
      offset = size > 0 ? aligned(offset, size) + size : cdr_end(definition(line.type), offset);
    }
  }
  return offset;
}

// every offset: equal sizes do not reveal two swapped fields
#define RECORD(record, ...)                                                   \
  static_assert(cdr_end(Schema<record>::text, 0) == sizeof(record), #record); \
  namespace check_##record {                                                  \
    using Record = record;
#define FIELD(type, field, ...) \
  static_assert(cdr_end(Schema<Record>::text, 0, #field) == offsetof(Record, field), #field);
#define ARRAY(type, count, field, ...) FIELD(type, field)
#define PART(type, count, field, ...) FIELD(type, field)
#define END(record) }
#include "proto/wire/records.def"

/// The `index`-th of comma-separated units; a single unit applies to every member.
std::string_view unit_of_member(std::string_view units, size_t index) {
  if (units.find(',') == std::string_view::npos) return units;
  for (; index > 0; --index) units.remove_prefix(std::min(units.find(',') + 2, units.size()));
  return units.substr(0, units.find(','));
}

/// Lists the numbers of a message; `Find` gives the definition of a nested type.
template <typename Find>
class Flattener {
 public:
  explicit Flattener(const Find& find) : find_(find) {}

  Fields flattened(std::string_view text) {
    add_message(text, "", "", 0);
    out_.bytes = offset_;
    return std::move(out_);
  }

 private:
  /// Appends the numbers of a message; `units` are those the enclosing field states.
  void add_message(std::string_view text, const std::string& prefix, std::string_view units,
                   int depth) {
    read_ += text.size() + 1;
    if (read_ > kMostFlattened || depth > kMostDepth) {
      throw std::runtime_error("it nests types too deep or too often");
    }
    size_t member = 0;
    for (Line line; take_line(text, line); ++member) {
      // the enclosing field's units take precedence: an impulse is a Wrench, but not in newtons
      const std::string_view unit = units.empty() ? line.unit : unit_of_member(units, member);
      const bool is_behind = !in_part_ && !out_.parts.empty();
      if (line.is_part || is_behind) {
        add_part(line, unit, depth);
      } else {
        add_values(line, prefix + std::string(line.name), unit, depth);
      }
    }
  }

  /// Behind the last field, so that all fields have their places.
  void add_part(const Line& line, std::string_view unit, int depth) {
    if (!line.is_part || depth > 0 || in_part_) {
      throw std::runtime_error("it has a field behind a sequence, or a sequence in another type");
    }
    if (offset_ % 8 != 0) throw std::runtime_error("it has a sequence that begins within a word");
    const size_t begin = offset_;
    const std::string name(line.name);
    add_number({"n_" + name, "uint32", begin, ""});
    offset_ = begin + kPartHeader;
    const size_t first = out_.size();
    in_part_ = true;
    add_values(line, name, unit, depth);
    in_part_ = false;
    const size_t element = (offset_ - begin - kPartHeader) / line.count;
    if (first == out_.size() || element % 8 != 0 || size_of(out_[first]) != 8) {
      throw std::runtime_error("it has a sequence of values that are not whole words");
    }
    out_.parts.push_back({begin, element, line.count});
  }

  void add_values(const Line& line, const std::string& name, std::string_view unit, int depth) {
    for (size_t i = 0; i < std::max<size_t>(line.count, 1); ++i) {
      const std::string index = line.count > 0 ? "[" + std::to_string(i) + "]" : "";
      add_value(line.type, name + index, unit, depth);
    }
  }

  void add_value(std::string_view type, const std::string& name, std::string_view unit, int depth) {
    const size_t size = primitive_size(type);
    if (size == 0) return add_message(find_(type), name + ".", unit, depth + 1);
    offset_ = aligned(offset_, size);
    add_number({name, std::string(type), offset_, std::string(unit)});
    offset_ += size;
  }

  void add_number(Field field) {
    if (out_.size() == kMostFields) throw std::runtime_error("it has more than 16384 numbers");
    out_.push_back(std::move(field));
  }

  const Find& find_;
  Fields out_;
  size_t offset_ = 0, read_ = 0;
  bool in_part_ = false;
};

template <typename Find>
Fields flatten_with(std::string_view text, const Find& find) {
  return Flattener(find).flattened(text);
}

bool is_name(std::string_view word, std::string_view others) {
  return !word.empty() && word.size() <= kLongestName &&
         std::all_of(word.begin(), word.end(), [&](char c) {
           const bool is_digit = c >= '0' && c <= '9';
           return is_digit || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                  others.find(c) != std::string_view::npos;
         });
}

/// Removes the first line from a text and returns it without its comment.
std::string_view take_code(std::string_view& text) {
  const size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line.substr(0, line.find('#'));
}

/// Definitions of a message ("") and its nested types. Comments are left out: text that is read
/// once for each element of an array has to be short.
std::map<std::string, std::string, std::less<>> split_definition(std::string_view text) {
  if (text.size() > kMostText) throw std::runtime_error("it has more than 64 KiB");
  std::map<std::string, std::string, std::less<>> types;
  std::string* into = &types[""];
  while (!text.empty()) {
    std::string_view code = take_code(text);
    const std::string_view line = code;
    const std::string_view type = take_word(code), name = take_word(code);
    if (type.empty() || type.starts_with("====")) continue;
    if (!take_word(code).empty()) throw std::runtime_error("it has a line that is no field");
    if (type == "MSG:") {
      const auto [place, is_new] = types.try_emplace(std::string(name));
      if (!is_new) throw std::runtime_error("it defines a type twice");
      if (types.size() > kMostTypes) throw std::runtime_error("it defines more than 64 types");
      into = &place->second;
    } else if (is_name(type, "_/[]<=") && is_name(name, "_")) {
      *into += std::string(line) + '\n';
    } else {
      throw std::runtime_error("it has a line that is no field");
    }
  }
  return types;
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
    out.replace(at, line.name.size(), lower_case(line.name));
  }
  return out;
}

}  // namespace

const std::vector<RecordRow>& all_records() {
  static const std::vector<RecordRow> rows = [] {
    std::vector<RecordRow> all;
#define SINCE(...) \
  Since {          \
    __VA_ARGS__    \
  }
#define RECORD(record, writer, doc) \
  {                                 \
    using Record = record;          \
    all.push_back({#record, writer, doc, Schema<record>::text, sizeof(Record), {}});
#define ROW(type, count, field, is_part, ...)                                 \
  all.back().fields.push_back({#type, #field, count, offsetof(Record, field), \
                               sizeof(Record::field), is_part, __VA_ARGS__});
#define FIELD(type, field, ...) ROW(type, 0, field, false, __VA_ARGS__)
#define ARRAY(type, count, field, ...) ROW(type, count, field, false, __VA_ARGS__)
#define PART(type, most, field, ...) ROW(type, most, field, true, __VA_ARGS__)
#define END(record) }
#include "proto/wire/records.def"
#undef ROW
#undef SINCE
    return all;
  }();
  return rows;
}

const RecordRow* find_record(std::string_view name) {
  const auto row = std::ranges::find(all_records(), name, &RecordRow::name);
  return row == all_records().end() ? nullptr : &*row;
}

Fields flatten(std::string_view text) {
  return flatten_with(text, [](std::string_view type) { return definition(type); });
}

Fields flatten_definition(std::string_view definition) {
  const auto types = split_definition(definition);
  return flatten_with(types.at(""), [&](std::string_view type) -> std::string_view {
    const auto found = types.find(type);
    if (found == types.end()) throw std::runtime_error("it lacks the definition of a type");
    return found->second;
  });
}

size_t size_of(const Field& field) {
  return primitive_size(field.type);
}

std::string lower_case(std::string_view name) {
  std::string out(name);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
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
