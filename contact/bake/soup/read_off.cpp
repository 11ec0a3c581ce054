// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/soup/formats.h"
#include "contact/bake/soup/text.h"

namespace haptic {

void read_off(std::string_view bytes, SoupReader& reader) {
  TextCursor cursor(bytes, reader.path());
  const std::string_view magic = cursor.word();
  if (!magic.ends_with("OFF")) cursor.fail("an OFF file starts with 'OFF'; export it again");
  if (magic.find_first_of("4n") != std::string_view::npos) {
    cursor.fail("points of other than three coordinates are not read; export as OFF, STL or PLY");
  }
  const std::string_view first = cursor.word();
  if (first == "BINARY") cursor.fail("binary OFF is not read; export as text OFF, STL or PLY");
  const uint64_t vertices = cursor.count(first), polygons = cursor.count(cursor.word());
  cursor.count(cursor.word());
  // smallest text: "0 0 0" and "3 0 1 2", each with a line end
  reader.check_announced(
      vertices, polygons,
      6.0 * static_cast<double>(vertices) + 8.0 * static_cast<double>(polygons) - 1);
  for (uint64_t i = 0; i < vertices; ++i) {
    Vec3 p;
    for (int k = 0; k < 3; ++k) p[k] = cursor.coordinate(cursor.word());
    reader.add_point(p);
    // COFF, NOFF …: the line continues with colours and normals
    if (magic != "OFF") cursor.next_line();
  }
  for (uint64_t i = 0; i < polygons; ++i) {
    std::vector<size_t> corners;
    for (uint64_t left = cursor.count(cursor.word()); left > 0; --left) {
      corners.push_back(cursor.index(cursor.word(), vertices));
    }
    reader.add_polygon(std::move(corners));
    cursor.next_line();
  }
}

}  // namespace haptic
