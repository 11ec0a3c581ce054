// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/mesh_files.h"

#include <sstream>

namespace haptic::test {
namespace {

std::string ply_header(const Soup& soup, const std::string& format) {
  return "ply\nformat " + format + " 1.0\nelement vertex " + std::to_string(soup.vertices.size()) +
         "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
         std::to_string(soup.triangles.size()) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

}  // namespace

std::string as_off(const Soup& soup) {
  std::ostringstream out;
  out.precision(17);
  out << "OFF\n# a comment\n" << soup.vertices.size() << " " << soup.triangles.size() << " 0\n";
  for (const Vec3& v : soup.vertices) out << v.x << " " << v.y << " " << v.z << "\n";
  for (const auto& [a, b, c] : soup.triangles) out << "3 " << a << " " << b << " " << c << "\n";
  return out.str();
}

std::string as_obj(const Soup& soup) {
  std::ostringstream out;
  out.precision(17);
  for (const Vec3& v : soup.vertices) out << "v " << v.x << " " << v.y << " " << v.z << "\n";
  out << "vn 0 0 1\n";
  for (const auto& [a, b, c] : soup.triangles) {
    out << "f " << a + 1 << "//1 " << b + 1 << "//1 " << c + 1 << "//1\n";
  }
  return out.str();
}

std::string as_text_stl(const Soup& soup) {
  std::ostringstream out;
  out.precision(17);
  out << "solid thing\n";
  for (const Triangle& t : soup.triangles) {
    out << "facet normal 0 0 0\nouter loop\n";
    for (const uint32_t i : t) {
      const Vec3& v = soup.vertices[i];
      out << "vertex " << v.x << " " << v.y << " " << v.z << "\n";
    }
    out << "endloop\nendfacet\n";
  }
  out << "endsolid thing\n";
  return out.str();
}

std::string as_binary_stl(const Soup& soup) {
  std::string out = "solid in name only";
  out.resize(80, ' ');
  append(out, static_cast<uint32_t>(soup.triangles.size()));
  for (const Triangle& t : soup.triangles) {
    for (int i = 0; i < 3; ++i) append(out, 0.0f);
    for (const uint32_t i : t) {
      for (int k = 0; k < 3; ++k) append(out, static_cast<float>(soup.vertices[i][k]));
    }
    append(out, uint16_t{0});
  }
  return out;
}

std::string as_text_ply(const Soup& soup) {
  std::ostringstream out;
  out.precision(17);
  out << ply_header(soup, "ascii");
  for (const Vec3& v : soup.vertices) out << v.x << " " << v.y << " " << v.z << "\n";
  for (const auto& [a, b, c] : soup.triangles) out << "3 " << a << " " << b << " " << c << "\n";
  return out.str();
}

std::string as_binary_ply(const Soup& soup) {
  std::string out = ply_header(soup, "binary_little_endian");
  for (const Vec3& v : soup.vertices) append(out, v.x), append(out, v.y), append(out, v.z);
  for (const Triangle& t : soup.triangles) {
    append(out, uint8_t{3});
    for (const uint32_t i : t) append(out, static_cast<int32_t>(i));
  }
  return out;
}

}  // namespace haptic::test
