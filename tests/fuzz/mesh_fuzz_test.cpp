// SPDX-License-Identifier: GPL-3.0-or-later
// Arbitrary mesh files: each is refused in one line, or quickly becomes a mesh with valid numbers.
// docs/fuzzing.md has the counts of a long run.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "contact/bake/bake.h"
#include "contact/query/point/closest_point.h"
#include "contact/query/point/segment_hit.h"
#include "tests/fuzz/fuzz_meter.h"
#include "tests/fuzz/mesh_inputs.h"
#include "tests/support/torture_scale.h"

namespace haptic::test {
namespace {

constexpr uint64_t kPlenty = uint64_t{1} << 30;  // [bytes]

bool is_finite_row(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Length 1, or 0 for a triangle without area.
bool is_normal(const Vec3& n) {
  return is_finite_row(n) && (std::fabs(norm(n) - 1) < 1e-9 || norm(n) == 0);
}

/// Whether each edge is used as often in one direction as in the other, by the corners alone.
bool is_balanced(const TriangleMesh& mesh) {
  std::map<std::pair<uint32_t, uint32_t>, int> sides;
  for (const Triangle& t : mesh.triangles) {
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t a = t[i], b = t[(i + 1) % 3];
      sides[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  }
  return std::all_of(sides.begin(), sides.end(), [](const auto& s) { return s.second == 0; });
}

/// Defects of an accepted mesh; empty if there are none.
std::string defect_of(const BakedShape& baked) {
  const TriangleMesh& mesh = baked.shape.mesh;
  const BakeReport& report = baked.report;
  for (const Triangle& t : mesh.triangles) {
    for (const uint32_t i : t) {
      if (i >= mesh.vertices.size()) return "an index out of range";
    }
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return "a triangle of two corners";
  }
  if (mesh.triangles.empty()) return "no triangle";
  const auto all = [](const auto& rows, auto holds) {
    return std::all_of(rows.begin(), rows.end(), holds);
  };
  if (!all(mesh.vertices, is_finite_row)) return "a vertex that is not finite";
  if (!all(mesh.face_normals, is_normal) || !all(mesh.vertex_normals, is_normal) ||
      !all(mesh.edge_normals, is_normal)) {
    return "a normal that is none";
  }
  if (!all(baked.eye_vertices, is_finite_row) || !all(baked.eye_normals, is_finite_row)) {
    return "a vertex for the eye that is not finite";
  }
  if (report.closed != is_balanced(mesh) || mesh.closed != report.closed) return "not as closed";
  if (report.triangles != mesh.triangles.size() || report.vertices != mesh.vertices.size()) {
    return "other numbers than reported";
  }
  if (!(report.size > 0) || !std::isfinite(report.size)) return "no size";
  return "";
}

/// A few queries on an accepted mesh; they must end with numbers.
bool answers(const MeshShape& shape, FuzzMeter::Random& random) {
  const Vec3 side = shape.mesh.upper - shape.mesh.lower;
  std::uniform_real_distribution<double> u(-0.5, 1.5);
  for (int i = 0; i < 4; ++i) {
    Vec3 p[2];
    for (Vec3& q : p) {
      q = shape.mesh.lower + Vec3{u(random) * side.x, u(random) * side.y, u(random) * side.z};
    }
    const SegmentHit hit = first_hit(shape, p[0], p[1]);
    const ClosestPoint near = closest_point(shape, p[0], 10 * norm(side));
    if (!std::isfinite(hit.t) || !is_finite_row(near.point_O)) return false;
  }
  return true;
}

bool bake_one(const MeshInput& input, FuzzMeter::Random& random) {
  ShapeConfig object{};
  assign(object.mesh, input.name);
  object.unit = random() % 2 == 0 ? 1 : 0;
  if (object.unit == 0) object.size = 0.1;
  object.allow_open = random() % 4 > 0;
  try {
    const BakedShape baked = bake_contents(input.bytes, object, kPlenty);
    const std::string defect = defect_of(baked);
    const bool is_wanted = baked.report.closed || object.allow_open != 0;
    const bool has_answers = answers(baked.shape, random);
    if (!defect.empty() || !is_wanted || !has_answers) {
      CAPTURE(input.name, input.bytes);
      CHECK(defect == "");
      CHECK(is_wanted);
      CHECK(has_answers);
    }
    return true;
  } catch (const MeshError& error) {
    const std::string message = error.what();
    if (message.starts_with(input.name) && message.find('\n') == std::string::npos) return false;
    CAPTURE(input.bytes);
    CHECK(message == "one line that begins with the file's name");
    return false;
  }
}

/// The long form has a million inputs in total.
void fuzz(const char* name, MeshInput (*make)(FuzzMeter::Random&)) {
  FuzzMeter meter(name, 1, kMostSeconds);
  meter.run(sweep(4000), [&](FuzzMeter::Random& random) { return bake_one(make(random), random); });
  if (!meter.is_whole()) return;
  CHECK(meter.accepted() > 0);
  CHECK(meter.refused() > 0);
}

}  // namespace

TEST_CASE("fuzz: meshes of polygons that are bent, crossing and degenerate") {
  fuzz("fuzz: meshes of polygons", random_polygons);
}

TEST_CASE("fuzz: meshes that are closed, with corners moved") {
  fuzz("fuzz: meshes that are closed", moved_prism);
}

TEST_CASE("fuzz: meshes of triangles between few points") {
  fuzz("fuzz: meshes of triangles", random_triangles);
}

TEST_CASE("fuzz: meshes in damaged files of every format") {
  fuzz("fuzz: meshes in damaged files", damaged_file);
}

}  // namespace haptic::test
