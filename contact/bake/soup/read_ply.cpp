// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "contact/bake/soup/formats.h"
#include "contact/bake/soup/text.h"

namespace haptic {
namespace {

enum class Encoding { kText, kLittleEndian, kBigEndian };
enum class Number : uint8_t { kSigned, kUnsigned, kReal };

struct Type {
  Number number = Number::kSigned;
  size_t bytes = 0;
};

struct Property {
  std::string name;
  Type type;         // of a scalar, or of an entry of a list
  Type length_type;  // of a list's length; 0 bytes: a scalar
  bool is_list() const { return length_type.bytes > 0; }
};

struct Element {
  std::string name;
  uint64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  Encoding encoding = Encoding::kText;
  std::vector<Element> elements;
  const Element* find(std::string_view name) const {
    const auto it = std::find_if(elements.begin(), elements.end(),
                                 [&](const Element& e) { return e.name == name; });
    return it == elements.end() ? nullptr : &*it;
  }
};

bool is_corners(const Property& property) {
  return property.is_list() &&
         (property.name == "vertex_indices" || property.name == "vertex_index");
}

/// Axis of a vertex coordinate; −1 for other properties.
int axis_of(const Property& property) {
  const bool is_place = property.name.size() == 1 && property.name[0] >= 'x';
  return is_place && property.name[0] <= 'z' && !property.is_list() ? property.name[0] - 'x' : -1;
}

Type type_of(const TextCursor& cursor, std::string_view name) {
  struct Named {
    std::string_view old_name, name;
    Type type;
  };
  static constexpr Named kTypes[] = {
      {"char", "int8", {Number::kSigned, 1}},   {"uchar", "uint8", {Number::kUnsigned, 1}},
      {"short", "int16", {Number::kSigned, 2}}, {"ushort", "uint16", {Number::kUnsigned, 2}},
      {"int", "int32", {Number::kSigned, 4}},   {"uint", "uint32", {Number::kUnsigned, 4}},
      {"float", "float32", {Number::kReal, 4}}, {"double", "float64", {Number::kReal, 8}},
  };
  for (const Named& known : kTypes) {
    if (name == known.old_name || name == known.name) return known.type;
  }
  cursor.fail("unknown property type; export the mesh again");
}

Encoding encoding_of(const TextCursor& cursor, std::string_view name) {
  if (name == "ascii") return Encoding::kText;
  if (name == "binary_little_endian") return Encoding::kLittleEndian;
  if (name == "binary_big_endian") return Encoding::kBigEndian;
  cursor.fail("unknown format; export the mesh again");
}

Property read_property(TextCursor& cursor) {
  Property property;
  std::string_view type = cursor.word_on_line();
  if (type == "list") {
    property.length_type = type_of(cursor, cursor.word_on_line());
    type = cursor.word_on_line();
  }
  property.type = type_of(cursor, type);
  property.name = cursor.word_on_line();
  if (property.length_type.number == Number::kReal ||
      (is_corners(property) && property.type.number == Number::kReal)) {
    cursor.fail("a count or an index that is no integer; export the mesh again");
  }
  return property;
}

/// Leaves the cursor after the line "end_header".
Header read_header(TextCursor& cursor) {
  if (cursor.word_on_line() != "ply") cursor.fail("a PLY file starts with 'ply'; export it again");
  Header header;
  while (cursor.next_line()) {
    const std::string_view key = cursor.word_on_line();
    if (key == "end_header") {
      cursor.next_line();
      return header;
    }
    if (key == "format") {
      header.encoding = encoding_of(cursor, cursor.word_on_line());
    } else if (key == "element") {
      const std::string name(cursor.word_on_line());
      header.elements.push_back({name, cursor.count(cursor.word_on_line()), {}});
    } else if (key == "property") {
      if (header.elements.empty()) cursor.fail("a property before any element; export it again");
      header.elements.back().properties.push_back(read_property(cursor));
    }
  }
  cursor.fail("no 'end_header': truncated; export it again");
}

/// The numbers after the header of a text PLY.
class TextNumbers {
 public:
  explicit TextNumbers(const TextCursor& cursor) : cursor_(cursor) {}

  void begin_row(const Element&, uint64_t) {}
  double coordinate(Type) { return cursor_.coordinate(cursor_.word()); }
  uint64_t length(Type) { return cursor_.count(cursor_.word()); }
  uint64_t index(Type, uint64_t limit) { return cursor_.index(cursor_.word(), limit); }
  void skip(Type, uint64_t n) {
    for (; n > 0; --n) {
      if (cursor_.word().empty()) {
        cursor_.fail("the file ends within a row: truncated; export it again");
      }
    }
  }

 private:
  TextCursor cursor_;
};

/// The numbers after the header of a binary PLY.
class BinaryNumbers {
 public:
  BinaryNumbers(std::string_view bytes, Encoding encoding, const SoupReader& reader)
      : rest_(bytes),
        is_swapped_((encoding == Encoding::kBigEndian) ==
                    (std::endian::native == std::endian::little)),
        reader_(reader) {}

  void begin_row(const Element& element, uint64_t row) {
    element_ = &element;
    row_ = row;
  }
  double coordinate(Type type) {
    const double value = number(type);
    if (!std::isfinite(value)) fail("has a coordinate that is not finite");
    return value;
  }
  uint64_t length(Type type) {
    const double value = number(type);
    if (value < 0) fail("has a list of negative length");
    return static_cast<uint64_t>(value);
  }
  uint64_t index(Type type, uint64_t limit) {
    const double value = number(type);
    if (value < 0 || value >= static_cast<double>(limit)) fail("has a vertex index out of range");
    return static_cast<uint64_t>(value);
  }
  void skip(Type type, uint64_t n) {
    if (n > rest_.size() / type.bytes) fail("is not whole: truncated or damaged");
    rest_.remove_prefix(n * type.bytes);
  }

 private:
  template <class T>
  T take() {
    std::array<char, sizeof(T)> bytes;
    std::copy_n(rest_.begin(), sizeof(T), bytes.begin());
    if (is_swapped_) std::reverse(bytes.begin(), bytes.end());
    return std::bit_cast<T>(bytes);
  }
  /// Every PLY number fits into a double.
  double number(Type type) {
    if (rest_.size() < type.bytes) fail("is not whole: truncated or damaged");
    const double value = value_of(type);
    rest_.remove_prefix(type.bytes);
    return value;
  }
  template <class Signed, class Unsigned>
  double integer(Type type) {
    return type.number == Number::kSigned ? static_cast<double>(take<Signed>())
                                          : static_cast<double>(take<Unsigned>());
  }
  double value_of(Type type) {
    if (type.bytes == 8) return take<double>();
    if (type.number == Number::kReal) return static_cast<double>(take<float>());
    if (type.bytes == 4) return integer<int32_t, uint32_t>(type);
    if (type.bytes == 2) return integer<int16_t, uint16_t>(type);
    return integer<int8_t, uint8_t>(type);
  }
  [[noreturn]] void fail(const std::string& what) const {
    reader_.fail(element_->name + " " + std::to_string(row_ + 1) + " " + what +
                 "; export the mesh again");
  }

  std::string_view rest_;
  bool is_swapped_;
  const SoupReader& reader_;
  const Element* element_ = nullptr;
  uint64_t row_ = 0;
};

template <class Numbers>
void read_rows(Numbers numbers, const Header& header, SoupReader& reader) {
  const uint64_t n_vertices = header.find("vertex")->count;
  for (const Element& element : header.elements) {
    const bool is_vertex = element.name == "vertex", is_face = element.name == "face";
    for (uint64_t row = 0; row < element.count; ++row) {
      numbers.begin_row(element, row);
      Vec3 point;
      std::vector<size_t> corners;
      for (const Property& property : element.properties) {
        const int axis = is_vertex ? axis_of(property) : -1;
        const uint64_t n = property.is_list() ? numbers.length(property.length_type) : 1;
        if (axis >= 0) {
          point[axis] = numbers.coordinate(property.type);
        } else if (is_face && is_corners(property)) {
          for (uint64_t i = 0; i < n; ++i) {
            corners.push_back(numbers.index(property.type, n_vertices));
          }
        } else {
          numbers.skip(property.type, n);
        }
      }
      if (is_vertex) reader.add_point(point);
      if (is_face) reader.add_polygon(std::move(corners));
    }
  }
}

/// Least size of the announced rows [bytes].
double least_bytes(const Header& header) {
  double sum = 0;
  for (const Element& element : header.elements) {
    for (const Property& property : element.properties) {
      const Type& first = property.is_list() ? property.length_type : property.type;
      // text: a digit and a blank
      double bytes = header.encoding == Encoding::kText ? 2 : static_cast<double>(first.bytes);
      // every face has at least three corners
      if (is_corners(property) && header.encoding != Encoding::kText) {
        bytes += 3 * static_cast<double>(property.type.bytes);
      }
      sum += static_cast<double>(element.count) * bytes;
    }
  }
  return sum;
}

/// Checks that rows of this element are not empty, points have coordinates, and faces have corners.
void check_element(const Element& element, const SoupReader& reader) {
  const auto& all = element.properties;
  if (element.count > 0 && all.empty()) {
    reader.fail("element '" + element.name + "' announces " + std::to_string(element.count) +
                " rows and no property; mend its header or export the mesh again");
  }
  if (element.name == "face" && std::count_if(all.begin(), all.end(), is_corners) != 1) {
    reader.fail("its faces have no list 'vertex_indices'; export the mesh again");
  }
  if (element.name != "vertex") return;
  for (const int axis : {0, 1, 2}) {
    const auto is_this = [axis](const Property& property) { return axis_of(property) == axis; };
    if (std::any_of(all.begin(), all.end(), is_this)) continue;
    reader.fail("its vertices have no x, y and z; export the mesh again");
  }
}

}  // namespace

void read_ply(std::string_view bytes, SoupReader& reader) {
  TextCursor cursor(bytes, reader.path());
  const Header header = read_header(cursor);
  const Element* vertex = header.find("vertex");
  const Element* face = header.find("face");
  if (vertex == nullptr || face == nullptr) {
    reader.fail("no vertices or no faces; export a surface");
  }
  for (const Element& element : header.elements) check_element(element, reader);
  reader.check_announced(vertex->count, face->count,
                         least_bytes(header) - 1 + static_cast<double>(bytes.size()) -
                             static_cast<double>(cursor.rest().size()));
  if (header.encoding == Encoding::kText) {
    read_rows(TextNumbers(cursor), header, reader);
  } else {
    read_rows(BinaryNumbers(cursor.rest(), header.encoding, reader), header, reader);
  }
}

}  // namespace haptic
