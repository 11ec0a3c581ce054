// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/mesh_inputs.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <sstream>

#include "tests/support/mesh_files.h"

namespace haptic::test {
namespace {

using Random = std::mt19937_64;

double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

std::string as_polygon_obj(const PolygonSoup& soup) {
  std::ostringstream out;
  out.precision(17);
  for (const Vec3& p : soup.points) out << "v " << p.x << " " << p.y << " " << p.z << "\n";
  for (const auto& polygon : soup.polygons) {
    out << "f";
    for (const size_t i : polygon) out << " " << i + 1;
    out << "\n";
  }
  return out.str();
}

/// The rows common to OFF and text PLY.
std::string as_rows(const PolygonSoup& soup) {
  std::ostringstream out;
  out.precision(17);
  for (const Vec3& p : soup.points) out << p.x << " " << p.y << " " << p.z << "\n";
  for (const auto& polygon : soup.polygons) {
    out << polygon.size();
    for (const size_t i : polygon) out << " " << i;
    out << "\n";
  }
  return out.str();
}

std::string ply_header(const PolygonSoup& soup, const std::string& format) {
  return "ply\nformat " + format + " 1.0\nelement vertex " + std::to_string(soup.points.size()) +
         "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
         std::to_string(soup.polygons.size()) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

std::string as_binary_rows(const PolygonSoup& soup) {
  std::string out;
  for (const Vec3& p : soup.points) append(out, p.x), append(out, p.y), append(out, p.z);
  for (const auto& polygon : soup.polygons) {
    append(out, static_cast<uint8_t>(polygon.size()));
    for (const size_t i : polygon) append(out, static_cast<int32_t>(i));
  }
  return out;
}

MeshInput written(const PolygonSoup& soup, Random& random) {
  switch (random() % 4) {
    case 0:
      return {"fuzz.obj", as_polygon_obj(soup)};
    case 1:
      return {"fuzz.off", "OFF\n" + std::to_string(soup.points.size()) + " " +
                              std::to_string(soup.polygons.size()) + " 0\n" + as_rows(soup)};
    case 2:
      return {"fuzz.ply", ply_header(soup, "ascii") + as_rows(soup)};
    default:
      return {"fuzz.ply", ply_header(soup, "binary_little_endian") + as_binary_rows(soup)};
  }
}

/// A prism of height 1 over a polygon of n corners on a wavy circle.
PolygonSoup prism(size_t n, Random& random) {
  PolygonSoup soup;
  std::vector<size_t> bottom, top;
  for (const double z : {0.0, 1.0}) {
    for (size_t i = 0; i < n; ++i) {
      const double angle = 6.283185307179586 * static_cast<double>(i) / static_cast<double>(n);
      const double radius = z == 0 ? uniform(random, 0.3, 1) : norm(soup.points[i]);
      soup.points.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
    }
  }
  for (size_t i = 0; i < n; ++i) {
    const size_t next = (i + 1) % n;
    soup.polygons.push_back({i, next, n + next, n + i});
    bottom.insert(bottom.begin(), i);
    top.push_back(n + i);
  }
  soup.polygons.push_back(bottom);
  soup.polygons.push_back(top);
  return soup;
}

/// A valid triangle mesh in a file of any format.
MeshInput right_file(Random& random) {
  const Soup soup = random() % 2 == 0 ? make_box({1, 2, 3}) : make_icosphere(1, 0);
  switch (random() % 7) {
    case 0:
      return {"fuzz.obj", as_obj(soup)};
    case 1:
      return {"fuzz.off", as_off(soup)};
    case 2:
      return {"fuzz.stl", as_text_stl(soup)};
    case 3:
      return {"fuzz.stl", as_binary_stl(soup)};
    case 4:
      return {"fuzz.ply", as_text_ply(soup)};
    case 5:
      return {"fuzz.ply", as_binary_ply(soup)};
    default:
      return written(prism(3 + random() % 6, random), random);
  }
}

// words and fragments that parsers fail on
constexpr const char* kWords[] = {"0",
                                  "-1",
                                  "3",
                                  "255",
                                  "65536",
                                  "2147483648",
                                  "4294967295",
                                  "9000000000000000000",
                                  "-9223372036854775808",
                                  "18446744073709551616",
                                  "1e308",
                                  "-1e308",
                                  "1e-320",
                                  "1e999",
                                  "nan",
                                  "inf",
                                  "1.5D0",
                                  "0x10",
                                  "+",
                                  "-",
                                  ".",
                                  "e",
                                  "#",
                                  "\\",
                                  "\\\n",
                                  "\t",
                                  "\r\n",
                                  "\n\n",
                                  "/",
                                  "//",
                                  "v",
                                  "f",
                                  "OFF",
                                  "COFF",
                                  "BINARY",
                                  "solid",
                                  "facet",
                                  "endfacet",
                                  "endsolid",
                                  "vertex",
                                  "ply",
                                  "list",
                                  "float",
                                  "uint",
                                  "vertex_indices",
                                  "end_header\n",
                                  "\nelement junk 9000000000000000000\n",
                                  "\nelement face 2\n",
                                  "\nproperty list uint int a\n",
                                  "\nproperty double x\n",
                                  "\xef\xbb\xbf"};

std::string odd_bytes(Random& random) {
  if (random() % 3 > 0) return kWords[random() % std::size(kWords)];
  static constexpr uint32_t kNumbers[] = {
      0, 1, 0x7f7fffff, 0x7f800000, 0x7fc00000, 0x7fffffff, 0x80000000, 0xffffffff, 3, 255};
  std::string bytes;
  append(bytes, kNumbers[random() % std::size(kNumbers)]);
  return bytes;
}

/// The word of a text around a position, as begin and length.
std::pair<size_t, size_t> word_at(const std::string& text, size_t at) {
  const auto is_blank = [](char c) { return c == ' ' || c == '\n'; };
  size_t begin = at, end = at;
  while (begin > 0 && !is_blank(text[begin - 1])) --begin;
  while (end < text.size() && !is_blank(text[end])) ++end;
  return {begin, end - begin};
}

void damage(std::string& bytes, Random& random) {
  const size_t at = random() % bytes.size();
  const size_t length = std::min<size_t>(1 + random() % 40, bytes.size() - at);
  switch (random() % 8) {
    case 0:
      bytes[at] = static_cast<char>(random());
      break;
    case 1:
      bytes[at] = static_cast<char>(bytes[at] ^ 1 << random() % 8);
      break;
    case 2:
      bytes.erase(at, length);
      break;
    case 3:
      bytes.insert(random() % bytes.size(), bytes.substr(at, length));
      break;
    case 4:
      bytes.resize(at);
      break;
    case 5:
      bytes.insert(at, odd_bytes(random));
      break;
    case 6: {
      const std::string odd = odd_bytes(random);
      bytes.replace(at, std::min(odd.size(), bytes.size() - at), odd);
      break;
    }
    default: {
      const auto [begin, size] = word_at(bytes, at);
      bytes.replace(begin, size, odd_bytes(random));
    }
  }
}

}  // namespace

MeshInput random_polygons(Random& random) {
  PolygonSoup soup;
  const uint64_t kind = random() % 4;
  const double scale = random() % 8 == 0 ? std::pow(10, uniform(random, -300, 300)) : 1;
  for (size_t i = 3 + random() % 8; i > 0; --i) {
    Vec3 p;
    for (int k = 0; k < 3; ++k) {
      // points of a grid lie on each other's edges; nearly planar polygons are what people draw
      p[k] = kind == 0 ? static_cast<double>(random() % 4) : uniform(random, -1, 1);
      if (kind == 1 && k == 2) p[k] *= 1e-16;
    }
    soup.points.push_back(scale * p);
  }
  for (size_t f = 1 + random() % 3; f > 0; --f) {
    std::vector<size_t> polygon;
    for (size_t i = 0; i < soup.points.size(); ++i) polygon.push_back(i);
    std::shuffle(polygon.begin(), polygon.end(), random);
    polygon.resize(3 + random() % (polygon.size() - 2));
    if (random() % 8 == 0) polygon.push_back(polygon[random() % polygon.size()]);
    soup.polygons.push_back(polygon);
  }
  return written(soup, random);
}

MeshInput moved_prism(Random& random) {
  PolygonSoup soup = prism(3 + random() % 6, random);
  const double by = std::array{0.0, 1e-16, 1e-9, 0.1, 1.0}[random() % 5];
  for (Vec3& p : soup.points) {
    for (int k = 0; k < 3; ++k) p[k] += by * uniform(random, -1, 1);
  }
  // some corners coincide, some are collinear
  for (uint64_t n = random() % 3; n > 0; --n) {
    soup.points[random() % soup.points.size()] = soup.points[random() % soup.points.size()];
  }
  if (random() % 4 == 0) soup.points[0] = 0.5 * (soup.points[1] + soup.points[2]);
  return written(soup, random);
}

MeshInput random_triangles(Random& random) {
  PolygonSoup soup;
  for (size_t i = 4 + random() % 10; i > 0; --i) {
    soup.points.push_back({static_cast<double>(random() % 3), static_cast<double>(random() % 3),
                           static_cast<double>(random() % 3)});
  }
  for (size_t f = 1 + random() % 30; f > 0; --f) {
    const auto corner = [&] { return random() % soup.points.size(); };
    soup.polygons.push_back({corner(), corner(), corner()});
  }
  return written(soup, random);
}

MeshInput damaged_file(Random& random) {
  MeshInput input = right_file(random);
  for (uint64_t n = 1 + random() % 4; n > 0 && !input.bytes.empty(); --n) {
    damage(input.bytes, random);
  }
  return input;
}

}  // namespace haptic::test
