// SPDX-License-Identifier: Apache-2.0
#include "proto/ipc/eye_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "proto/math/assert.h"

namespace haptic {
namespace {

static_assert(std::endian::native == std::endian::little, "eye files are mapped, not converted");

constexpr std::array<char, 8> kMagic{'H', 'A', 'P', 'T', 'E', 'Y', 'E', '1'};

struct Header {
  std::array<char, 8> magic;
  uint32_t n_vertices, n_triangles, n_points, object;
  EyeColour colour;
  std::array<char, kEyeNameBytes> name;
};
static_assert(sizeof(Header) == kEyeHeaderBytes && offsetof(Header, n_vertices) == 8 &&
              offsetof(Header, colour) == 24 && offsetof(Header, name) == 40);
static_assert(sizeof(EyePoint) == 12 && sizeof(EyeTriangle) == 12);

/// Cannot wrap: four counts below 2³² of 12 bytes each.
uint64_t size_of(const Header& h) {
  return sizeof(Header) +
         sizeof(EyePoint) * (2 * uint64_t{h.n_vertices} + h.n_triangles + uint64_t{h.n_points});
}

/// The longest beginning of at most kEyeNameBytes that does not end within a character.
std::string_view fitting(std::string_view name) {
  if (name.size() <= kEyeNameBytes) return name;
  size_t size = kEyeNameBytes;
  while (size > 0 && (static_cast<uint8_t>(name[size]) & 0xc0) == 0x80) --size;
  return name.substr(0, size);
}

template <typename T>
std::span<const T> take(const std::byte*& at, size_t count) {
  const auto* first = reinterpret_cast<const T*>(at);
  at += count * sizeof(T);
  return {first, count};
}

template <typename T>
void put(std::byte*& at, std::span<const T> array) {
  // an empty array has no address to copy from
  if (!array.empty()) std::memcpy(at, array.data(), array.size_bytes());
  at += array.size_bytes();
}

void require(bool ok, const std::string& what) {
  if (!ok) throw EyeError("eye file: " + what);
}

bool is_finite(const EyePoint& p) {
  // what is not finite minus itself is not a number
  return p[0] - p[0] + (p[1] - p[1]) + (p[2] - p[2]) == 0;
}

void require_finite(std::span<const EyePoint> points, const char* what) {
  const auto bad = std::find_if_not(points.begin(), points.end(), is_finite);
  require(bad == points.end(),
          std::string(what) + " " + std::to_string(bad - points.begin()) + " is not finite");
}

void require_in_range(const EyeFile& file) {
  for (const EyeTriangle& triangle : file.triangles) {
    const uint32_t largest = std::max({triangle[0], triangle[1], triangle[2]});
    if (largest < file.vertices.size()) continue;
    require(false, "triangle " + std::to_string(&triangle - file.triangles.data()) +
                       " names vertex " + std::to_string(largest) + " of " +
                       std::to_string(file.vertices.size()));
  }
}

void require_colour(const EyeColour& colour) {
  for (const float share : {colour.r, colour.g, colour.b, colour.a}) {
    require(share >= 0 && share <= 1, "its colour is not between 0 and 1");
  }
}

}  // namespace

EyeFile view_eye(std::span<const std::byte> bytes) {
  HAPTIC_ASSERT(reinterpret_cast<uintptr_t>(bytes.data()) % alignof(uint32_t) == 0);
  require(bytes.size() >= sizeof(Header),
          std::to_string(bytes.size()) + " bytes, shorter than its header");
  require(bytes.size() <= kMostEyeBytes, std::to_string(bytes.size()) +
                                             " bytes, more than is read (" +
                                             std::to_string(kMostEyeBytes) + ")");
  Header header;
  std::memcpy(&header, bytes.data(), sizeof header);
  require(header.magic == kMagic,
          "it does not begin with HAPTEYE1; not of hapticd, or of another version");
  require(
      bytes.size() == size_of(header),
      std::to_string(bytes.size()) + " bytes, its counts need " + std::to_string(size_of(header)));
  require_colour(header.colour);
  const auto* name_end = std::find(header.name.begin(), header.name.end(), '\0');
  const std::string_view name(header.name.begin(), name_end);
  const std::byte* at = bytes.data() + sizeof header;
  EyeFile file{header.object,
               shown(name),
               header.colour,
               take<EyePoint>(at, header.n_vertices),
               take<EyePoint>(at, header.n_vertices),
               take<EyeTriangle>(at, header.n_triangles),
               take<EyePoint>(at, header.n_points)};
  require_finite(file.vertices, "vertex");
  require_finite(file.normals, "normal");
  require_finite(file.points, "point");
  require_in_range(file);
  return file;
}

std::vector<std::byte> write_eye(const EyeFile& file) {
  require(file.normals.size() == file.vertices.size(), "it needs one normal for each vertex");
  for (const size_t n : {file.vertices.size(), file.triangles.size(), file.points.size()}) {
    require(n <= kMostEyeBytes / sizeof(EyePoint), "it has too many vertices, triangles or points");
  }
  const auto count = [](const auto& array) { return static_cast<uint32_t>(array.size()); };
  Header header{kMagic,
                count(file.vertices),
                count(file.triangles),
                count(file.points),
                file.object,
                file.colour,
                {}};
  const std::string_view name = fitting(file.name);
  std::copy(name.begin(), name.end(), header.name.begin());
  std::vector<std::byte> bytes(size_of(header));
  std::byte* at = bytes.data();
  put(at, std::span<const Header>(&header, 1));
  put(at, file.vertices);
  put(at, file.normals);
  put(at, file.triangles);
  put(at, file.points);
  view_eye(bytes);
  return bytes;
}

}  // namespace haptic
