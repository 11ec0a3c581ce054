// SPDX-License-Identifier: GPL-3.0-or-later
// Eye files that others have damaged: each is refused in one line, or all its arrays can be drawn.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "contact/shape/mesh/primitives.h"
#include "proto/ipc/eye_file.h"
#include "tests/fuzz/fuzz_run.h"
#include "tests/fuzz/hostile_input.h"

namespace haptic {
namespace {

std::string good_file() {
  Soup soup = make_icosphere(0.01, 1);
  std::vector<EyePoint> points;
  for (const Vec3& v : soup.vertices) {
    points.push_back({static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)});
  }
  const std::vector<std::byte> bytes = write_eye({.object = 2,
                                                  .name = "Kügelchen",
                                                  .colour = {},
                                                  .vertices = points,
                                                  .normals = points,
                                                  .triangles = soup.triangles,
                                                  .points = points});
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Reads every number that a viewer would.
double drawn(const EyeFile& file) {
  double sum = 0;
  for (const auto& [i, j, k] : file.triangles) {
    for (const uint32_t v : {i, j, k}) {
      sum += double{file.vertices[v][0]} + double{file.normals[v][2]};
    }
  }
  for (const EyePoint& p : file.points) sum += double{p[1]};
  return sum;
}

}  // namespace

TEST_CASE("fuzz: whatever an eye file holds, it is refused in one line or can be drawn") {
  const std::string good = good_file();
  const test::Damage damage({"HAPTEYE1", std::string(4, '\0'), std::string(12, '\xff'),
                             std::string("\x00\x00\xc0\x7f", 4), "\x1b[2J"});
  test::FuzzRun fuzz("eye file", 6, 20'000);
  fuzz.run([&](test::FuzzRandom& random) {
    // one number only, or anything; the header is hit as often as the arrays
    std::string text = good;
    const size_t edge = random.below(2) == 0 ? kEyeHeaderBytes : text.size();
    if (random.below(2) == 0) {
      const uint64_t bits = random.bits();
      std::memcpy(text.data() + 4 * random.below(edge / 4), &bits, 4);
    } else {
      text = damage.apply(text.substr(0, edge), random) + good.substr(edge);
    }
    // aligned, and without a byte to spare that a sanitizer would not see
    std::vector<std::byte> bytes(text.size());
    std::memcpy(bytes.data(), text.data(), text.size());
    const EyeFile file = view_eye(bytes);
    if (!std::isfinite(drawn(file))) throw std::runtime_error("not finite:\n");
    if (!file.name.empty() && !test::is_one_line(file.name)) throw std::runtime_error("name:\n");
  });
  CHECK(fuzz.accepted() > 0);
  CHECK(fuzz.accepted() < fuzz.inputs());
}

}  // namespace haptic
