// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <cstring>

#include "contact/bake/soup/formats.h"
#include "contact/bake/soup/text.h"

namespace haptic {
namespace {

constexpr uint64_t kHeaderBytes = 84, kTriangleBytes = 50;  // 80 bytes of anything, and the count
constexpr std::string_view kSolid = "solid";

/// Whether a word is that keyword, in either case: both are common.
bool is_keyword(std::string_view word, std::string_view keyword) {
  return std::equal(word.begin(), word.end(), keyword.begin(), keyword.end(),
                    [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a - 'A' + 'a' : a) == b; });
}

/// A text file begins with the word "solid" and has no zero byte, which the count of a binary file
/// has.
bool is_text(std::string_view bytes) {
  const std::string_view head = bytes.substr(0, kHeaderBytes);
  const size_t begin = std::min(head.find_first_not_of(" \t\r\n"), head.size());
  return is_keyword(head.substr(begin, kSolid.size()), kSolid) &&
         head.find('\0') == std::string_view::npos;
}

/// A text file is a sequence of words: line ends matter only after the name.
void read_text(std::string_view bytes, SoupReader& reader) {
  TextCursor cursor(bytes, reader.path());
  bool is_open = false;
  std::vector<size_t> corners;
  for (std::string_view word = cursor.word(); !word.empty(); word = cursor.word()) {
    if (is_keyword(word, kSolid) || is_keyword(word, "endsolid")) {
      is_open = is_keyword(word, kSolid);
      cursor.next_line();
    } else if (is_keyword(word, "vertex")) {
      Vec3 p;
      for (int i = 0; i < 3; ++i) p[i] = cursor.coordinate(cursor.word());
      corners.push_back(reader.n_points());
      reader.add_point(p);
    } else if (is_keyword(word, "endfacet")) {
      if (corners.size() != 3) cursor.fail("a facet has three vertices; export the mesh again");
      reader.add_polygon(std::move(corners));
      corners.clear();
    }
  }
  if (is_open || !corners.empty()) {
    cursor.fail("no 'endsolid' at the end: truncated; export it again");
  }
}

void read_binary(std::string_view bytes, uint32_t facets, SoupReader& reader) {
  for (uint32_t f = 0; f < facets; ++f) {
    float values[12];  // the normal, then three corners
    std::memcpy(values, bytes.data() + kHeaderBytes + kTriangleBytes * f, sizeof values);
    if (!std::all_of(values + 3, values + 12, [](float x) { return std::isfinite(x); })) {
      reader.fail("triangle " + std::to_string(f + 1) +
                  " has a coordinate that is not finite; export the mesh again");
    }
    const size_t first = reader.n_points();
    for (int i = 3; i < 12; i += 3) {
      reader.add_point({double{values[i]}, double{values[i + 1]}, double{values[i + 2]}});
    }
    reader.add_polygon({first, first + 1, first + 2});
  }
}

}  // namespace

void read_stl(std::string_view bytes, SoupReader& reader) {
  uint32_t facets = 0;
  if (bytes.size() >= kHeaderBytes) std::memcpy(&facets, bytes.data() + 80, sizeof facets);
  const uint64_t announced = kHeaderBytes + kTriangleBytes * facets;
  // binary files may start with "solid", too: the size decides, then the zero bytes
  const bool is_whole = bytes.size() >= kHeaderBytes && bytes.size() == announced;
  if (!is_whole && is_text(bytes)) return read_text(bytes, reader);
  if (bytes.size() < kHeaderBytes) {
    reader.fail("shorter than an STL header: truncated; export it again");
  }
  reader.check_announced(3 * uint64_t{facets}, facets, static_cast<double>(announced));
  read_binary(bytes, facets, reader);
}

}  // namespace haptic
