// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <optional>

#include "contact/bake_read.h"

namespace haptic {
namespace {

// peak while baking, measured on spheres of 0.3 and 1.3 million triangles
constexpr uint64_t kBakeBytesPerTriangle = 1000;
constexpr uint64_t kStlHeaderBytes = 84, kStlTriangleBytes = 50;

/// Walks through text, counting lines.
class Cursor {
 public:
  Cursor(std::string_view text, const std::string& path) : rest_(text), path_(path) {}

  /// Next word on this line; empty at its end or at a comment.
  std::string_view word_on_line() {
    const size_t start = rest_.find_first_not_of(" \t\r\v\f");
    rest_.remove_prefix(std::min(start, rest_.size()));
    const size_t end = std::min(rest_.find_first_of(" \t\r\v\f\n"), rest_.size());
    if (end > 0 && rest_[0] == '#') return {};
    const std::string_view word = rest_.substr(0, end);
    rest_.remove_prefix(end);
    return word;
  }
  /// Next word anywhere; empty at the end of the file.
  std::string_view word() {
    for (;;) {
      const std::string_view found = word_on_line();
      if (!found.empty() || !next_line()) return found;
    }
  }
  /// Goes to the start of the next line; false where there is none.
  bool next_line() {
    const size_t end = rest_.find('\n');
    if (end == std::string_view::npos) {
      rest_ = {};
      return false;
    }
    rest_.remove_prefix(end + 1);
    ++line_;
    return true;
  }
  std::string_view rest() const { return rest_; }
  [[noreturn]] void fail(const std::string& what) const {
    throw MeshError(path_ + ":" + std::to_string(line_) + ": " + what);
  }

  double coordinate(std::string_view text) const {
    if (text.empty()) fail("the file ends within a vertex: truncated; export it again");
    if (text[0] == '+') text.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc::invalid_argument || end != text.data() + text.size()) {
      fail("'" + std::string(text) + "' is not a number; export the mesh again");
    }
    if (error != std::errc{}) {
      fail("coordinate '" + std::string(text) + "' is out of range; export the mesh again");
    }
    if (!std::isfinite(value)) {
      fail("coordinate '" + std::string(text) + "' is not finite; export the mesh again");
    }
    return value;
  }
  int64_t integer(std::string_view text, const char* what) const {
    int64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (text.empty() || error != std::errc{} || end != text.data() + text.size()) {
      fail(std::string(what) + " expected, '" + std::string(text) +
           "' found: truncated or damaged; export the mesh again");
    }
    return value;
  }
  /// A count or an index below `limit`.
  uint64_t index(std::string_view text, uint64_t limit) const {
    const int64_t value = integer(text, "a vertex index");
    if (value < 0 || static_cast<uint64_t>(value) >= limit) {
      fail("vertex index " + std::to_string(value) + " is out of range 0 to " +
           std::to_string(static_cast<int64_t>(limit) - 1) + "; export the mesh again");
    }
    return static_cast<uint64_t>(value);
  }
  uint64_t count(std::string_view text) const {
    const int64_t value = integer(text, "a count");
    if (value < 0) fail("negative count " + std::to_string(value) + "; export the mesh again");
    return static_cast<uint64_t>(value);
  }

 private:
  std::string_view rest_;
  const std::string& path_;
  size_t line_ = 1;
};

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw MeshError(path + ": " + what);
}

std::string mebibytes(double bytes) {
  return std::to_string(static_cast<uint64_t>(std::ceil(bytes / (1 << 20)))) + " MiB";
}

/// Announced counts against the memory limit and the bytes that are there.
void check_announced(const std::string& path, uint64_t vertices, uint64_t polygons,
                     uint64_t triangles, double bytes_needed, size_t file_bytes, uint64_t limit) {
  const bool fits = bytes_needed <= static_cast<double>(file_bytes);
  try {
    check_mesh_memory(triangles, limit, path);
  } catch (const MeshError& error) {
    if (fits) throw;
    throw MeshError(std::string(error.what()) + " (or mend its header: a file of " +
                    std::to_string(file_bytes) + " bytes cannot hold that many)");
  }
  if (fits) return;
  fail(path, "announces " + std::to_string(vertices) + " vertices and " + std::to_string(polygons) +
                 " faces, but " + std::to_string(file_bytes) +
                 " bytes cannot hold them: truncated or damaged; export it again");
}

uint64_t polygon_triangles(uint64_t corners) {
  return corners > 2 ? corners - 2 : 0;
}

MeshFileFacts scan_obj(std::string_view bytes, const std::string& path, uint64_t limit) {
  Cursor cursor(bytes, path);
  uint64_t vertices = 0, polygons = 0, triangles = 0;
  struct Highest {
    int64_t index = 0;
    Cursor at;
  };
  std::optional<Highest> highest;
  do {
    const std::string_view key = cursor.word_on_line();
    if (key == "v") {
      for (int i = 0; i < 3; ++i) cursor.coordinate(cursor.word_on_line());
      ++vertices;
    } else if (key == "f") {
      uint64_t corners = 0;
      for (auto word = cursor.word_on_line(); !word.empty(); word = cursor.word_on_line()) {
        const int64_t i = cursor.integer(word.substr(0, word.find('/')), "a vertex index");
        if (i == 0 || i < -static_cast<int64_t>(vertices)) {
          cursor.fail("vertex index " + std::to_string(i) + " is out of range; export it again");
        }
        // faces may stand before their vertices: the highest index is judged at the end
        if (i > (highest ? highest->index : 0)) highest.emplace(Highest{i, cursor});
        ++corners;
      }
      if (corners < 3) cursor.fail("a face needs three corners: truncated; export it again");
      ++polygons;
      triangles += polygon_triangles(corners);
    }
  } while (cursor.next_line());
  if (highest && highest->index > static_cast<int64_t>(vertices)) {
    highest->at.fail("vertex index " + std::to_string(highest->index) + " is out of range 1 to " +
                     std::to_string(vertices) + ": truncated or damaged; export it again");
  }
  check_mesh_memory(triangles, limit, path);
  return {MeshFormat::kObj, polygons};
}

MeshFileFacts scan_off(std::string_view bytes, const std::string& path, uint64_t limit) {
  Cursor cursor(bytes, path);
  const std::string_view magic = cursor.word();
  if (!magic.ends_with("OFF")) cursor.fail("an OFF file starts with 'OFF'; export it again");
  const std::string_view first = cursor.word();
  if (first == "BINARY") cursor.fail("binary OFF is not read; export as text OFF, STL or PLY");
  const uint64_t vertices = cursor.count(first), polygons = cursor.count(cursor.word());
  cursor.count(cursor.word());
  // "0 0 0" and "3 0 1 2", each with a line end
  check_announced(path, vertices, polygons, polygons,
                  6.0 * static_cast<double>(vertices) + 8.0 * static_cast<double>(polygons) - 1,
                  bytes.size(), limit);
  for (uint64_t i = 0; i < vertices; ++i) {
    for (int k = 0; k < 3; ++k) cursor.coordinate(cursor.word());
    // COFF, NOFF …: colours and normals fill the line
    if (magic != "OFF") cursor.next_line();
  }
  uint64_t triangles = 0;
  for (uint64_t i = 0; i < polygons; ++i) {
    const uint64_t corners = cursor.count(cursor.word());
    for (uint64_t k = 0; k < corners; ++k) cursor.index(cursor.word(), vertices);
    triangles += polygon_triangles(corners);
    cursor.next_line();
  }
  check_mesh_memory(triangles, limit, path);
  return {MeshFormat::kOff, polygons};
}

MeshFileFacts scan_text_stl(std::string_view bytes, const std::string& path, uint64_t limit) {
  Cursor cursor(bytes, path);
  uint64_t facets = 0;
  int corners = 0;
  bool open = false;
  do {
    const std::string_view key = cursor.word_on_line();
    if (key == "solid") open = true;
    if (key == "endsolid") open = false;
    if (key == "vertex") {
      for (int i = 0; i < 3; ++i) cursor.coordinate(cursor.word_on_line());
      ++corners;
    } else if (key == "endfacet") {
      if (corners != 3) cursor.fail("a facet has three vertices; export the mesh again");
      corners = 0;
      ++facets;
    }
  } while (cursor.next_line());
  if (open || corners != 0) cursor.fail("no 'endsolid' at the end: truncated; export it again");
  check_mesh_memory(facets, limit, path);
  return {MeshFormat::kStl, facets};
}

MeshFileFacts scan_stl(std::string_view bytes, const std::string& path, uint64_t limit) {
  uint32_t facets = 0;
  if (bytes.size() >= kStlHeaderBytes) std::memcpy(&facets, bytes.data() + 80, sizeof facets);
  const uint64_t announced = kStlHeaderBytes + kStlTriangleBytes * facets;
  // binary files may start with "solid" too: the size decides, then the word "facet"
  const bool binary = bytes.size() >= kStlHeaderBytes && bytes.size() == announced;
  const bool text = bytes.starts_with("solid") &&
                    (bytes.substr(0, 1000).find("facet") != std::string_view::npos ||
                     bytes.substr(0, 1000).find("endsolid") != std::string_view::npos ||
                     bytes.size() < kStlHeaderBytes);
  if (!binary && text) return scan_text_stl(bytes, path, limit);
  if (bytes.size() < kStlHeaderBytes)
    fail(path, "shorter than an STL header: truncated; export it again");
  check_announced(path, 3 * uint64_t{facets}, facets, facets, static_cast<double>(announced),
                  bytes.size(), limit);
  for (uint32_t f = 0; f < facets; ++f) {
    float values[12];
    std::memcpy(values, bytes.data() + kStlHeaderBytes + kStlTriangleBytes * f, sizeof values);
    for (int i = 3; i < 12; ++i) {
      if (std::isfinite(values[i])) continue;
      fail(path, "triangle " + std::to_string(f + 1) +
                     " has a coordinate that is not finite; export the mesh again");
    }
  }
  return {MeshFormat::kStl, facets};
}

struct PlyProperty {
  std::string name;
  uint64_t bytes = 0;        // of a scalar or of one list entry
  uint64_t count_bytes = 0;  // of a list's length; 0: a scalar
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;
  uint64_t least_bytes(bool text) const {
    uint64_t sum = 0;
    for (const PlyProperty& p : properties) {
      if (text)
        sum += 2;
      else
        sum += p.count_bytes > 0 ? p.count_bytes : p.bytes;
    }
    return sum;
  }
};

uint64_t ply_type_bytes(const Cursor& cursor, std::string_view type) {
  for (const std::string_view name : {"char", "uchar", "int8", "uint8"})
    if (type == name) return 1;
  for (const std::string_view name : {"short", "ushort", "int16", "uint16"})
    if (type == name) return 2;
  for (const std::string_view name : {"int", "uint", "float", "int32", "uint32", "float32"})
    if (type == name) return 4;
  for (const std::string_view name : {"double", "float64"})
    if (type == name) return 8;
  cursor.fail("unknown property type '" + std::string(type) + "'; export the mesh again");
}

struct PlyHeader {
  bool text = false;
  std::vector<PlyElement> elements;
  const PlyElement* find(std::string_view name) const {
    const auto it = std::find_if(elements.begin(), elements.end(),
                                 [&](const PlyElement& e) { return e.name == name; });
    return it == elements.end() ? nullptr : &*it;
  }
};

PlyHeader scan_ply_header(Cursor& cursor) {
  if (cursor.word_on_line() != "ply") cursor.fail("a PLY file starts with 'ply'; export it again");
  PlyHeader header;
  while (cursor.next_line()) {
    const std::string_view key = cursor.word_on_line();
    if (key == "end_header") {
      cursor.next_line();
      return header;
    }
    if (key == "format") {
      header.text = cursor.word_on_line() == "ascii";
    } else if (key == "element") {
      const std::string name(cursor.word_on_line());
      header.elements.push_back({name, cursor.count(cursor.word_on_line()), {}});
    } else if (key == "property") {
      if (header.elements.empty()) cursor.fail("a property before any element; export it again");
      PlyProperty property;
      std::string_view type = cursor.word_on_line();
      if (type == "list") {
        property.count_bytes = ply_type_bytes(cursor, cursor.word_on_line());
        type = cursor.word_on_line();
      }
      property.bytes = ply_type_bytes(cursor, type);
      property.name = cursor.word_on_line();
      header.elements.back().properties.push_back(property);
    }
  }
  cursor.fail("no 'end_header': truncated; export it again");
}

/// One row of a text PLY; returns the number of triangles of a face.
uint64_t scan_ply_row(Cursor& cursor, const PlyElement& element, uint64_t vertices) {
  uint64_t triangles = 0;
  for (const PlyProperty& property : element.properties) {
    const bool corners = property.name == "vertex_indices" || property.name == "vertex_index";
    const bool place = property.name == "x" || property.name == "y" || property.name == "z";
    if (property.count_bytes == 0) {
      const std::string_view word = cursor.word();
      if (element.name == "vertex" && place) cursor.coordinate(word);
      if (word.empty()) cursor.fail("the file ends within a row: truncated; export it again");
      continue;
    }
    const uint64_t count = cursor.count(cursor.word());
    for (uint64_t i = 0; i < count; ++i) {
      const std::string_view word = cursor.word();
      if (element.name == "face" && corners) cursor.index(word, vertices);
      if (word.empty()) cursor.fail("the file ends within a row: truncated; export it again");
    }
    if (corners) triangles = polygon_triangles(count);
  }
  return triangles;
}

MeshFileFacts scan_ply(std::string_view bytes, const std::string& path, uint64_t limit) {
  Cursor cursor(bytes, path);
  const PlyHeader header = scan_ply_header(cursor);
  const PlyElement* vertex = header.find("vertex");
  const PlyElement* face = header.find("face");
  if (vertex == nullptr || face == nullptr) fail(path, "no vertices or no faces; export a surface");
  double least = 0;
  for (const PlyElement& element : header.elements) {
    least +=
        static_cast<double>(element.count) * static_cast<double>(element.least_bytes(header.text));
  }
  // every face has three corners and more
  if (!header.text && !face->properties.empty()) {
    least +=
        3.0 * static_cast<double>(face->count) *
        static_cast<double>(face->properties[0].count_bytes > 0 ? face->properties[0].bytes : 0);
  }
  check_announced(path, vertex->count, face->count, face->count, least - 1, cursor.rest().size(),
                  limit);
  if (!header.text) return {MeshFormat::kPly, face->count};
  uint64_t triangles = 0;
  for (const PlyElement& element : header.elements) {
    for (uint64_t i = 0; i < element.count; ++i) {
      triangles += scan_ply_row(cursor, element, vertex->count);
    }
  }
  check_mesh_memory(triangles, limit, path);
  return {MeshFormat::kPly, face->count};
}

}  // namespace

void check_mesh_memory(uint64_t triangles, uint64_t memory_limit, const std::string& path) {
  const double needed = static_cast<double>(triangles) * static_cast<double>(kBakeBytesPerTriangle);
  if (needed <= static_cast<double>(memory_limit)) return;
  fail(path, std::to_string(triangles) + " triangles need about " + mebibytes(needed) +
                 " while baking and contact.mesh_memory_limit allows " +
                 mebibytes(static_cast<double>(memory_limit)) +
                 "; decimate the mesh or raise contact.mesh_memory_limit");
}

MeshFileFacts scan_mesh_file(std::string_view bytes, const std::string& path,
                             uint64_t memory_limit) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const bool known =
      extension == ".obj" || extension == ".off" || extension == ".ply" || extension == ".stl";
  if (!known) fail(path, "unknown extension '" + extension + "'; use .obj, .stl, .ply or .off");
  if (bytes.empty()) fail(path, "the file is empty; export the mesh again");
  const MeshFileFacts facts = extension == ".obj"   ? scan_obj(bytes, path, memory_limit)
                              : extension == ".off" ? scan_off(bytes, path, memory_limit)
                              : extension == ".ply" ? scan_ply(bytes, path, memory_limit)
                                                    : scan_stl(bytes, path, memory_limit);
  if (facts.polygons == 0) fail(path, "no triangles; export a surface, not points or lines");
  return facts;
}

}  // namespace haptic
