// SPDX-License-Identifier: GPL-3.0-or-later
// What the mesh readers accept and refuse: variants of each format, and invalid files.
#include "contact/bake/soup/read.h"

#include <catch2/catch.hpp>

#include "contact/bake/bake.h"
#include "tests/support/hostile_text.h"
#include "tests/support/mesh_files.h"

using namespace haptic;
using namespace haptic::test;
using Catch::Matchers::Contains;

namespace {

std::string read_error(const std::string& name, const std::string& bytes) {
  const std::string message = refusal<MeshError>([&] { read_mesh(bytes, name, kPlenty); });
  // one line of printable text with the position
  CHECK(std::all_of(message.begin(), message.end(), [](char c) { return c >= ' ' && c <= '~'; }));
  CHECK_THAT(message, Contains(name));
  return message;
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  for (size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += with.size()) {
    text.replace(at, what.size(), with);
  }
  return text;
}

/// The corners of each face as points, so that formats with and without indices compare.
std::vector<std::vector<Vec3>> places(const PolygonSoup& soup) {
  std::vector<std::vector<Vec3>> faces;
  for (const auto& polygon : soup.polygons) {
    faces.emplace_back();
    for (const size_t i : polygon) faces.back().push_back(soup.points[i]);
  }
  return faces;
}

struct Variant {
  const char* what;
  std::string bytes;
};

/// Checks that each variant has the content of the soup.
void check_variants(const std::string& name, const Soup& soup,
                    const std::vector<Variant>& variants) {
  std::vector<std::vector<Vec3>> faces;
  for (const Triangle& t : soup.triangles) {
    faces.push_back({soup.vertices[t[0]], soup.vertices[t[1]], soup.vertices[t[2]]});
  }
  for (const auto& [what, bytes] : variants) {
    CAPTURE(name, what);
    PolygonSoup read;
    CHECK_NOTHROW(read = read_mesh(bytes, name, kPlenty));
    CHECK(places(read) == faces);
  }
}

Soup box() {
  return make_box({1, 1, 1});
}

std::string indented(const std::string& text) {
  return "\n \t\n  " + replaced(text, "\n", "\n\t ");
}

/// An OFF with a colour behind each face.
std::string coloured_faces(const std::string& off) {
  const size_t faces = off.find("\n3 ") + 1;
  return off.substr(0, faces) + replaced(off.substr(faces), "\n", " 255 0 0\n");
}

const std::string kMark = "\xef\xbb\xbf";

}  // namespace

TEST_CASE("bake read: a text STL may have tabs, blanks, CRLF, capitals and any line breaks") {
  const std::string stl = as_text_stl(box());
  std::string words = replaced(stl, "\n", " ");
  words = first_replaced(words, "solid thing ", "solid thing\n");
  std::string capitals = stl;
  for (char& c : capitals) c = static_cast<char>(std::toupper(c));
  check_variants("thing.stl", box(),
                 {{"as it is", stl},
                  {"tab after solid", first_replaced(stl, "solid ", "solid\t")},
                  {"no name", first_replaced(stl, "solid thing", "solid")},
                  {"only a tab after solid", first_replaced(stl, "solid thing", "solid\t")},
                  {"tabs", replaced(stl, " ", "\t")},
                  {"CRLF", replaced(stl, "\n", "\r\n")},
                  {"leading blanks", indented(stl)},
                  {"trailing blanks", replaced(stl, "\n", " \t\n")},
                  {"capitals", capitals},
                  {"byte order mark", kMark + stl},
                  {"all words on one line", words},
                  {"a word a line", first_replaced(replaced(stl, " ", "\n"), "solid\n", "solid ")},
                  {"a long name", first_replaced(stl, "thing", std::string(5000, 'x'))},
                  {"a name of keywords", first_replaced(stl, "thing", "vertex endfacet solid")},
                  {"a plus and an exponent", replaced(stl, "vertex 0.5", "vertex +5.0E-01")},
                  {"no digit before the point", replaced(stl, "vertex 0.5", "vertex .5")},
                  {"no line end at the end", stl.substr(0, stl.size() - 1)}});
  Soup twice = box();
  twice.triangles.insert(twice.triangles.end(), twice.triangles.begin(), twice.triangles.end());
  check_variants("two.stl", twice, {{"two solids", stl + stl}});
}

TEST_CASE("bake read: a binary STL may begin with the word solid, and a cut one is no text") {
  const std::string stl = as_binary_stl(box());
  check_variants("b.stl", box(), {{"as it is", stl}});
  CHECK_THAT(read_error("b.stl", stl.substr(0, stl.size() - 1)), Contains("cannot hold"));
  CHECK_THAT(read_error("b.stl", stl.substr(0, 90)), Contains("cannot hold"));
}

TEST_CASE("bake read: an OBJ may have tabs, CRLF, comments, long lines and all kinds of indices") {
  const std::string obj = as_obj(box());
  std::string backwards = obj;
  for (int i = 8; i > 0; --i) {
    backwards = replaced(backwards, " " + std::to_string(i) + "//1", " -" + std::to_string(9 - i));
  }
  check_variants("thing.obj", box(),
                 {{"as it is", obj},
                  {"tabs", replaced(obj, " ", "\t")},
                  {"CRLF", replaced(obj, "\n", "\r\n")},
                  {"leading blanks", indented(obj)},
                  {"trailing blanks", replaced(obj, "\n", " \t\n")},
                  {"comments", "# of a box\n" + replaced(obj, "\n", " # x\n#\n")},
                  {"byte order mark", kMark + obj},
                  {"a line goes on after a backslash", replaced(obj, "//1 ", "//1 \\\n")},
                  {"a backslash and CRLF", replaced(obj, "//1 ", "//1\\\r\n")},
                  {"bare indices", replaced(obj, "//1", "")},
                  {"with texture", replaced(obj, "//1", "/1")},
                  {"with texture and normal", replaced(obj, "//1", "/1/1")},
                  {"indices from the end", backwards},
                  {"colours of vertices", replaced(obj, "0.5\n", "0.5 1 0 0\n")},
                  {"groups and materials", "mtllib x.mtl\no a\ng b\ns off\nusemtl c\n" + obj},
                  {"no line end at the end", obj.substr(0, obj.size() - 1)}});
}

TEST_CASE("bake read: an OFF may have tabs, CRLF, comments, colours and its counts in one line") {
  const std::string off = as_off(box());
  check_variants("thing.off", box(),
                 {{"as it is", off},
                  {"tabs", replaced(off, " ", "\t")},
                  {"CRLF", replaced(off, "\n", "\r\n")},
                  {"leading blanks", indented(off)},
                  {"comments", "# of a box\n" + replaced(off, "\n", " # x\n#\n")},
                  {"byte order mark", kMark + off},
                  {"counts behind OFF", first_replaced(off, "OFF\n# a comment\n", "OFF ")},
                  {"colours of faces", coloured_faces(off)},
                  {"colours of vertices", "C" + replaced(off, "0.5\n", "0.5 1 0 0 1\n")},
                  {"normals", "N" + replaced(off, "0.5\n", "0.5 1 0 0\n")},
                  {"no line end at the end", off.substr(0, off.size() - 1)}});
  CHECK_THAT(read_error("four.off", "4" + off), Contains("three coordinates"));
}

TEST_CASE("bake read: a PLY may have tabs, CRLF, comments and properties in any order and type") {
  const std::string ply = as_text_ply(box());
  const std::string faces = "element face";
  check_variants("thing.ply", box(),
                 {{"as it is", ply},
                  {"tabs", replaced(ply, " ", "\t")},
                  {"CRLF", replaced(ply, "\n", "\r\n")},
                  {"trailing blanks", replaced(ply, "\n", " \n")},
                  {"comments", first_replaced(ply, faces, "comment 1 2 3\nobj_info x\n" + faces)},
                  {"byte order mark", kMark + ply},
                  {"new names of types",
                   replaced(replaced(ply, "double", "float64"), "uchar int", "uint8 int32")},
                  {"vertex_index", replaced(ply, "vertex_indices", "vertex_index")},
                  {"an element that is not read",
                   first_replaced(ply, faces, "element junk 0\nproperty int a\n" + faces)},
                  {"an empty element without properties",
                   first_replaced(ply, faces, "element junk 0\n" + faces)}});
  const std::string binary = as_binary_ply(box());
  check_variants("b.ply", box(), {{"as it is", binary}, {"bytes behind the end", binary + "more"}});
}

namespace {

template <class T>
void append_swapped(std::string& out, T value) {
  std::string bytes;
  append(bytes, value);
  out.append(bytes.rbegin(), bytes.rend());
}

}  // namespace

TEST_CASE("bake read: a binary PLY of either byte order, with other properties between") {
  const Soup soup = box();
  for (const bool big : {false, true}) {
    CAPTURE(big);
    std::string ply = std::string("ply\nformat binary_") + (big ? "big" : "little") +
                      "_endian 1.0\nelement junk 2\nproperty list ushort short a\n"
                      "element vertex 8\nproperty uchar red\nproperty float z\nproperty double y\n"
                      "property float x\nelement face 12\nproperty ushort flags\n"
                      "property list uint ushort vertex_index\nend_header\n";
    const auto put = [&](auto value) { big ? append_swapped(ply, value) : append(ply, value); };
    put(uint16_t{2}), put(int16_t{-7}), put(int16_t{300}), put(uint16_t{0});
    for (const Vec3& v : soup.vertices) {
      put(uint8_t{200}), put(static_cast<float>(v.z)), put(v.y), put(static_cast<float>(v.x));
    }
    for (const Triangle& t : soup.triangles) {
      put(uint16_t{9}), put(uint32_t{3});
      for (const uint32_t i : t) put(static_cast<uint16_t>(i));
    }
    check_variants("e.ply", soup, {{"whole", ply}});
    CHECK_THAT(read_error("e.ply", ply.substr(0, ply.size() - 1)), Contains("face 12"));
  }
}

TEST_CASE("bake read: a PLY whose element has rows but no property is refused at once") {
  // rows of zero bytes, which no end of file ends
  const std::string junk = "element junk 9000000000000000000\n";
  for (const std::string& ply : {as_text_ply(box()), as_binary_ply(box())}) {
    CHECK_THAT(read_error("a.ply", first_replaced(ply, "element face", junk + "element face")),
               Contains("'junk'") && Contains("no property") && Contains("mend its header"));
    CHECK_THAT(read_error("b.ply", first_replaced(ply, "end_header", junk + "end_header")),
               Contains("'junk'"));
  }
  CHECK_THAT(read_error("v.ply",
                        "ply\nformat ascii 1.0\nelement vertex 9000000000000000000\n"
                        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
                        "3 0 1 2\n"),
             Contains("'vertex'"));
}

TEST_CASE("bake read: a list of a binary PLY that is longer than the file is refused at once") {
  std::string ply = as_binary_ply(box());
  ply = first_replaced(ply, "uchar int", "uint int");
  const size_t first = ply.find("end_header\n") + 11 + 8 * 24;
  ply.replace(first, 1, "\xff\xff\xff\xff");
  for (int i = 0; i < 36; ++i) ply += '\0';  // as long as the header says
  CHECK_THAT(read_error("l.ply", ply), Contains("face 1 "));
  ply = first_replaced(as_binary_ply(box()), "uchar int", "char int");
  ply[first] = '\x80';
  CHECK_THAT(read_error("n.ply", ply), Contains("face 1 has a list of negative length"));
}

TEST_CASE("bake read: numbers of other languages are refused, too small ones are zero") {
  const std::string obj = "v 0 0 0\nv 1 0 X\nv 0 1 0\nf 1 2 3\n";
  for (const char* word : {"1.5D+00", "1,5", "0x10", "+-1", "--1", "1e", "nan", "-inf", "1e999",
                           "1.#INF", "1_000", "one"}) {
    CAPTURE(word);
    CHECK_THAT(read_error("n.obj", replaced(obj, "X", word)), Contains("n.obj:2"));
  }
  CHECK(read_mesh(replaced(obj, "X", "1e-400"), "n.obj", kPlenty).points[1].z == 0);
  CHECK(read_mesh(replaced(obj, "X", "+.5e+1"), "n.obj", kPlenty).points[1].z == 5);
  // binary data is not quoted in a message
  read_error("n.obj", replaced(obj, "X", "\x1b[31m" + std::string(1000, '\x07')));
}

TEST_CASE(
    "bake read: a mesh that is too large or too small for any hand is refused with its size") {
  ObjectConfig object;
  object.unit = 1;
  assign(object.mesh, "thing.obj");
  for (const double side : {1e-10, 1e7, 1e150}) {
    CAPTURE(side);
    CHECK_THROWS_WITH(bake_contents(as_obj(make_box({side, side, side})), object, kPlenty),
                      Contains("thing.obj: its l") && Contains("state the right unit"));
  }
  // zero area by rounding: normals would not have length one
  const BakedShape baked = bake_contents(
      first_replaced(as_obj(box()), "f ", "v 0 0 1e-85\nv 0 1e-85 0\nv 0 0 0\nf -1 -2 -3\nf "),
      object, kPlenty);
  for (const Vec3& n : baked.shape.mesh.face_normals) CHECK(norm(n) == Approx(1));
}
