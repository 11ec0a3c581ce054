// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/bake.h"

#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "contact/bake/inside.h"
#include "contact/query/point/closest_point.h"
#include "contact/query/point/segment_hit.h"
#include "tests/support/hostile_text.h"
#include "tests/support/mesh_files.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"
#include "tests/support/temporary_folder.h"

using namespace haptic;
using namespace haptic::test;
using Catch::Matchers::Contains;

namespace {

constexpr double kLengthTolerance = 1e-12;  // [m]

ObjectConfig object_at(const std::string& path) {
  ObjectConfig object;
  assign(object.name, "thing");
  assign(object.mesh, path);
  object.unit = 1;
  return object;
}

std::string error_of(const ObjectConfig& object, uint64_t limit = kPlenty) {
  return refusal<MeshError>([&] { bake_object(object, limit); });
}

/// Folders for meshes and for the cache, which is set to it.
struct Bench {
  TemporaryFolder folder;
  std::string cache = folder.path() + "/cache";
  Environment in{"HAPTICD_CACHE", cache};

  std::string write(const std::string& name, const std::string& bytes) const {
    const std::string path = folder.path() + "/" + name;
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  /// A file with these bytes is refused, in one line that names it.
  void refuses(const std::string& name, const std::string& bytes,
               const std::vector<std::string>& says) const {
    const std::string message = error_of(object_at(write(name, bytes)));
    CHECK(message.find('\n') == std::string::npos);
    CHECK_THAT(message, Contains(name));
    for (const std::string& part : says) CHECK_THAT(message, Contains(part));
  }
};

std::string all_lines(const BakeReport& report) {
  std::string text;
  for (const std::string& line : report.lines) text += line + "\n";
  return text;
}

/// Rounded to a multiple of 2⁻²⁴: a float where |x| < 1. Not by a cast to float and back, which
/// g++ 12 drops in a vectorised loop.
double to_float_grid(double x) {
  return std::ldexp(std::round(std::ldexp(x, 24)), -24);
}

/// A sphere whose coordinates are floats, so that all formats can hold it.
Soup float_sphere() {
  Soup sphere = make_icosphere(0.05, 2);
  for (Vec3& v : sphere.vertices) {
    v = {to_float_grid(v.x), to_float_grid(v.y), to_float_grid(v.z)};
  }
  return sphere;
}

std::string cut(const std::string& text, size_t bytes) {
  return text.substr(0, text.size() - bytes);
}

std::filesystem::path only_file(const std::filesystem::path& folder) {
  std::filesystem::path found;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    CHECK(found.empty());
    found = entry.path();
  }
  return found;
}

std::string read_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

bool same_shape(const BakedShape& a, const BakedShape& b) {
  const auto same = [](const auto& x, const auto& y) {
    return std::equal(x.begin(), x.end(), y.begin(), y.end());
  };
  const TriangleMesh &m = a.shape.mesh, &n = b.shape.mesh;
  return same(m.vertices, n.vertices) && same(m.triangles, n.triangles) &&
         same(m.edge_normals, n.edge_normals) && same(m.vertex_normals, n.vertex_normals) &&
         same(a.shape.tree.order, b.shape.tree.order) && same(a.eye_vertices, b.eye_vertices) &&
         same(a.eye_triangles, b.eye_triangles) && a.report.lines == b.report.lines;
}

BakedShape bake(const Soup& soup, const ObjectConfig& object = {}) {
  return bake_soup(soup.vertices, soup.triangles, object);
}

}  // namespace

TEST_CASE("bake: all formats of one shape give the same mesh in double") {
  const Bench bench;
  const Soup sphere = float_sphere();
  const BakedShape reference = bake(sphere);
  REQUIRE(reference.shape.mesh.triangles.size() == sphere.triangles.size());
  for (const auto& [name, bytes] :
       {std::pair("s.off", as_off(sphere)), std::pair("s.obj", as_obj(sphere)),
        std::pair("a.STL", as_text_stl(sphere)), std::pair("b.stl", as_binary_stl(sphere)),
        std::pair("a.ply", as_text_ply(sphere)), std::pair("b.ply", as_binary_ply(sphere))}) {
    CAPTURE(name);
    const BakedShape baked = bake_object(object_at(bench.write(name, bytes)), kPlenty);
    CHECK(all_lines(baked.report) == "");
    CHECK(baked.shape.mesh.vertices.size() == reference.shape.mesh.vertices.size());
    CHECK(same_shape(baked, reference));
  }
  // doubles are preserved: no rounding to float on the way
  Soup fine = sphere;
  for (Vec3& v : fine.vertices) v *= 1 + 1e-12;
  const BakedShape baked = bake_object(object_at(bench.write("f.off", as_off(fine))), kPlenty);
  for (const Vec3& v : baked.shape.mesh.vertices) {
    CHECK(std::find(fine.vertices.begin(), fine.vertices.end(), v) != fine.vertices.end());
  }
}

TEST_CASE("bake: a file that is missing, empty, a folder or of unknown kind is named") {
  const Bench bench;
  CHECK_THAT(error_of(object_at("/nowhere/thing.obj")),
             Contains("/nowhere/thing.obj") && Contains("check the path"));
  CHECK_THAT(error_of(object_at(bench.folder.path())), Contains("is a folder"));
  bench.refuses("thing.obj", "", {"empty"});
  bench.refuses("thing.step", "x", {".step", "use .obj"});
}

TEST_CASE("bake: truncated files are refused in every format") {
  const Bench bench;
  const Soup sphere = float_sphere();
  const Soup box = make_box({1, 1, 1});
  bench.refuses("a.off", cut(as_off(sphere), 30), {"a.off:"});
  bench.refuses("b.off", as_off(sphere).substr(0, 60), {"cannot hold"});
  bench.refuses("c.off", "OFF\n8 12", {"c.off:2"});
  // a cut within the last face, and one before all vertices are read
  bench.refuses("a.obj", cut(as_obj(box), 6), {"three corners"});
  bench.refuses("b.obj", "f 1 2 3\nv 0 0 0\nv 1 0 0\n", {"b.obj:1"});
  bench.refuses("c.obj", "v 0 0 0\nv 1 0 0\nv 1 1", {"c.obj:3"});
  bench.refuses("a.stl", cut(as_text_stl(sphere), 40), {"truncated"});
  bench.refuses("b.stl", cut(as_binary_stl(sphere), 40), {"cannot hold"});
  bench.refuses("c.stl", "xx", {"truncated"});
  bench.refuses("a.ply", cut(as_text_ply(sphere), 4), {"truncated"});
  bench.refuses("b.ply", cut(as_binary_ply(sphere), 40), {"cannot hold"});
  bench.refuses("c.ply", "ply\nformat ascii 1.0\n", {"end_header"});
}

TEST_CASE("bake: NaN and infinite coordinates are refused with their line") {
  const Bench bench;
  const std::string obj = "v 0 0 0\nv 1 nan 0\nv 1 1 0\nf 1 2 3\n";
  bench.refuses("n.obj", obj, {"n.obj:2", "'nan'"});
  bench.refuses("i.obj", first_replaced(obj, "nan", "-inf"), {"i.obj:2"});
  bench.refuses("w.obj", first_replaced(obj, "nan", "1,5"), {"not a number"});
  bench.refuses("h.obj", first_replaced(obj, "nan", "1e999"), {"h.obj:2"});
  bench.refuses("n.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 nan\n3 0 1 2\n", {"n.off:5"});
  bench.refuses("n.stl", first_replaced(as_text_stl(make_box({1, 1, 1})), "-0.5", "NaN"),
                {"n.stl:4"});
  Soup box = make_box({1, 1, 1});
  box.vertices[3].y = std::nan("");
  bench.refuses("t.ply", as_text_ply(box), {"t.ply:13"});
  bench.refuses("b.ply", as_binary_ply(box), {"vertex 4"});
  bench.refuses("b.stl", as_binary_stl(box), {"triangle 3"});
  CHECK_THROWS_AS(bake(box), MeshError);
}

TEST_CASE("bake: files without triangles and with wrong indices are refused") {
  const Bench bench;
  bench.refuses("z.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", {"no triangles"});
  bench.refuses("z.off", "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n", {"no triangles"});
  bench.refuses("z.stl", "solid x\nendsolid x\n", {"no triangles"});
  bench.refuses("z.ply", as_text_ply({}), {"no triangles"});
  bench.refuses("r.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", {"r.obj:4", "out of range"});
  bench.refuses("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 1 2\n", {"m.obj:4"});
  bench.refuses("r.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", {"r.off:6", "0 to 2"});
  Soup box = make_box({1, 1, 1});
  box.triangles[5][1] = 8;
  bench.refuses("r.ply", as_text_ply(box), {"out of range"});
  bench.refuses("b.ply", as_binary_ply(box), {"face 6"});
  CHECK_THROWS_AS(bake(box), MeshError);
  // triangles, but all collinear
  bench.refuses("l.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", {"area"});
  bench.refuses("p.obj", "v 1 1 1\nf 1 1 1\n", {"area"});
}

TEST_CASE("bake: a mesh beyond the memory limit is refused before anything is read") {
  const Bench bench;
  const std::vector<std::string> says{"10000000 triangles", "4096 MiB", "contact.mesh_memory_limit",
                                      "header"};
  bench.refuses("huge.off", "OFF\n5000000 10000000 0\n0 0 0\n", says);
  bench.refuses("huge.ply",
                "ply\nformat binary_little_endian 1.0\nelement vertex 5000000\n"
                "property float x\nproperty float y\nproperty float z\nelement face 10000000\n"
                "property list uchar int vertex_indices\nend_header\n",
                says);
  std::string stl(80, ' ');
  append(stl, uint32_t{10000000});
  bench.refuses("huge.stl", stl, says);
  // the worst header: 2·10⁹ vertices
  bench.refuses("worst.off", "OFF\n2000000000 1 0\n0 0 0\n", {"cannot hold"});
  // formats without a header are counted
  const ObjectConfig sphere = object_at(bench.write("s.obj", as_obj(float_sphere())));
  CHECK_THAT(error_of(sphere, 100000), Contains("320 triangles"));
  CHECK(error_of(sphere, 1000000) == "");
}

TEST_CASE("bake: an open mesh is refused or, where allowed, used as a one-sided surface") {
  const Bench bench;
  Soup box = make_box({0.1, 0.1, 0.1});
  box.triangles.resize(10);
  ObjectConfig object = object_at(bench.write("open.off", as_off(box)));
  CHECK_THAT(error_of(object),
             Contains("not closed: 4 border edges") && Contains("mm") && Contains("open = true"));
  object.allow_open = 1;
  const BakedShape baked = bake_object(object, kPlenty);
  CHECK_FALSE(baked.shape.mesh.closed);
  CHECK_FALSE(baked.report.closed);
  CHECK(baked.report.border_edges == 4);
  CHECK_THAT(all_lines(baked.report), Contains("open: 4 border edges"));
  CHECK_THROWS_AS(InsideOracle(baked.shape.mesh), MeshError);
}

TEST_CASE("bake: faces of mixed orientation are made consistent and outward and it is said") {
  Soup sphere = make_icosphere(0.05, 2);
  for (size_t f = 0; f < sphere.triangles.size(); f += 3) {
    std::swap(sphere.triangles[f][0], sphere.triangles[f][1]);
  }
  const BakedShape mixed = bake(sphere);
  CHECK(mixed.report.reoriented);
  CHECK_THAT(all_lines(mixed.report), Contains("turned over"));
  CHECK(mixed.shape.mesh.closed);

  Soup inside_out = make_icosphere(0.05, 2);
  for (Triangle& t : inside_out.triangles) std::swap(t[0], t[1]);
  const BakedShape turned = bake(inside_out);
  CHECK(turned.report.reoriented);
  CHECK_THAT(all_lines(turned.report), Contains("320 faces") && Contains("inside out"));
  for (const BakedShape* baked : {&mixed, &turned}) {
    const TriangleMesh& mesh = baked->shape.mesh;
    for (size_t f = 0; f < mesh.triangles.size(); ++f) {
      REQUIRE(dot(mesh.face_normals[f], mesh.vertices[mesh.triangles[f][0]]) > 0);
    }
  }
  CHECK_FALSE(bake(make_icosphere(0.05, 2)).report.reoriented);
}

TEST_CASE("bake: a cavity stays a cavity") {
  Soup hollow = make_icosphere(0.05, 2);
  // outward like the shell: must be reversed
  append(hollow, make_icosphere(0.02, 1));
  const BakedShape baked = bake(hollow);
  CHECK(baked.report.components == 2);
  CHECK_FALSE(closest_point(baked.shape, {0.001, 0.002, 0}, 1).inside);
  CHECK(closest_point(baked.shape, {0.035, 0.002, 0}, 1).inside);
}

TEST_CASE("bake: degenerate and double faces are removed and counted") {
  Soup box = make_box({0.1, 0.1, 0.1});
  box.triangles.push_back({0, 0, 1});
  box.triangles.push_back({2, 3, 3});
  box.triangles.push_back(box.triangles[4]);
  const BakedShape baked = bake(box);
  CHECK(baked.report.degenerate_removed == 2);
  CHECK(baked.report.duplicate_removed == 1);
  CHECK_THAT(all_lines(baked.report), Contains("2 triangles without area removed"));
  CHECK_THAT(all_lines(baked.report), Contains("1 face that was there twice removed"));
  CHECK(baked.shape.mesh.closed);
  CHECK(baked.shape.mesh.triangles.size() == 12);

  // a vertex at the middle of an edge, closed by a triangle without area
  Soup sliver = make_box({0.1, 0.1, 0.1});
  const Triangle split = sliver.triangles[0];
  sliver.vertices.push_back(0.5 * (sliver.vertices[split[0]] + sliver.vertices[split[1]]));
  sliver.triangles[0] = {8, split[1], split[2]};
  sliver.triangles.push_back({split[0], 8, split[2]});
  sliver.triangles.push_back({split[0], split[1], 8});
  const BakedShape mended = bake(sliver);
  CHECK(mended.report.degenerate_removed == 1);
  CHECK(mended.shape.mesh.closed);
  for (const Vec3& n : mended.shape.mesh.face_normals) {
    CHECK(std::fabs(norm(n) - 1) < tol(kLengthTolerance));
  }
}

TEST_CASE("bake: unconnected triangles are sewn and touching parts are split") {
  // every corner three times, as in STL
  const Soup box = make_box({0.1, 0.1, 0.1});
  Soup loose;
  for (const Triangle& t : box.triangles) {
    const auto first = static_cast<uint32_t>(loose.vertices.size());
    for (const uint32_t i : t) loose.vertices.push_back(box.vertices[i]);
    loose.triangles.push_back({first, first + 1, first + 2});
  }
  CHECK(bake(loose).shape.mesh.vertices.size() == 8);

  // two boxes that share one edge: four faces at it
  Soup pair = box;
  append(pair, box, {0.1, 0.1, 0});
  const BakedShape split = bake(pair);
  CHECK(split.shape.mesh.closed);
  CHECK(split.report.components == 2);
  CHECK(split.report.non_manifold_split > 0);
  CHECK_THAT(all_lines(split.report), Contains("split"));
}

TEST_CASE("bake: self-intersections are a warning with their number") {
  Soup crossing = make_box({0.1, 0.1, 0.1});
  append(crossing, make_box({0.1, 0.1, 0.1}), {0.03, 0.04, 0.05});
  const BakedShape baked = bake(crossing);
  CHECK(baked.report.self_intersections > 0);
  CHECK_THAT(all_lines(baked.report), Contains("warning") && Contains("cut each other"));
}

TEST_CASE("bake: polygons are triangulated") {
  const Bench bench;
  const std::string cube =
      "OFF\n8 6 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n"
      "4 3 2 1 0\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n";
  const BakedShape baked = bake_object(object_at(bench.write("cube.off", cube)), kPlenty);
  CHECK(baked.shape.mesh.triangles.size() == 12);
  CHECK(baked.shape.mesh.closed);
}

TEST_CASE("bake: unit and size must agree and any unit is scaled") {
  const Bench bench;
  ObjectConfig object = object_at(bench.write("box.obj", as_obj(make_box({2.5, 1, 1}))));
  object.unit = 1e-3;
  object.size = 0.1;
  CHECK_THAT(error_of(object), Contains("states size 100 mm") && Contains("unit 'mm'") &&
                                   Contains("is 2.5 mm") && Contains("\"any\""));
  object.size = 0.00251;
  CHECK(bake_object(object, kPlenty).report.size == Approx(0.0025));
  object.unit = 0;
  object.size = 0.1;
  const BakedShape baked = bake_object(object, kPlenty);
  CHECK_THAT(baked.shape.mesh.upper, IsNear({0.05, 0.02, 0.02}, kLengthTolerance));
  CHECK(baked.report.size == Approx(0.1));
}

TEST_CASE("bake: a generated mesh of many triangles is cached by its shape, a small one is not") {
  const Bench bench;
  ObjectConfig molar;
  molar.primitive = primitive::LowerMolar{.around = 132};
  const BakedShape fresh = bake_object(molar, kPlenty);
  CHECK_FALSE(fresh.report.from_cache);
  CHECK(fresh.report.closed);
  const BakedShape cached = bake_object(molar, kPlenty);
  CHECK(cached.report.from_cache);
  CHECK(cached.shape.mesh.triangles.size() == fresh.shape.mesh.triangles.size());
  CHECK(std::ranges::equal(cached.shape.mesh.vertices, fresh.shape.mesh.vertices));
  // another shape is another entry
  molar.primitive = primitive::LowerMolar{.width = 12e-3, .around = 132};
  CHECK_FALSE(bake_object(molar, kPlenty).report.from_cache);
  ObjectConfig peg;
  peg.primitive = primitive::Peg{.grid = {24, 4}};
  CHECK_FALSE(bake_object(peg, kPlenty).report.from_cache);
  CHECK_FALSE(bake_object(peg, kPlenty).report.from_cache);
}

TEST_CASE("bake: the cache gives back the same shape and the same report, mapped") {
  const Bench bench;
  Soup sphere = make_icosphere(0.05, 3);
  std::swap(sphere.triangles[7][0], sphere.triangles[7][1]);
  ObjectConfig object = object_at(bench.write("s.off", as_off(sphere)));
  const BakedShape fresh = bake_object(object, kPlenty);
  const BakedShape cached = bake_object(object, kPlenty);
  CHECK_FALSE(fresh.report.from_cache);
  CHECK(cached.report.from_cache);
  CHECK(same_shape(fresh, cached));
  CHECK(cached.report.reoriented);
  CHECK(cached.report.triangles == 1280);
  // the spans must lie in the mapped file
  std::ifstream maps("/proc/self/maps");
  std::string line;
  bool mapped = false;
  const std::string name = only_file(bench.cache).string();
  while (std::getline(maps, line)) mapped = mapped || line.find(name) != std::string::npos;
  CHECK(mapped);

  // other options give another entry
  object.unit = 0;
  object.size = 0.2;
  CHECK_FALSE(bake_object(object, kPlenty).report.from_cache);
  CHECK(bake_object(object, kPlenty).report.from_cache);
}

TEST_CASE("bake: a damaged cache is said and baked again") {
  const Bench bench;
  const Soup sphere = make_icosphere(0.05, 2);
  const ObjectConfig object = object_at(bench.write("s.off", as_off(sphere)));
  const BakedShape fresh = bake_object(object, kPlenty);
  const std::filesystem::path file = only_file(bench.cache);
  const std::string good = read_file(file);
  std::string flipped = good, version = good;
  flipped[good.size() / 2] = static_cast<char>(flipped[good.size() / 2] ^ 4);
  version[8] = static_cast<char>(version[8] + 1);
  for (const std::string& bad : {cut(good, 100), good.substr(0, 20), std::string(), flipped,
                                 version, std::string("not a cache")}) {
    // a new inode: the old one may still be mapped
    std::filesystem::remove(file);
    std::ofstream(file, std::ios::binary) << bad;
    const BakedShape again = bake_object(object, kPlenty);
    CHECK_FALSE(again.report.from_cache);
    CHECK_THAT(all_lines(again.report), Contains("unusable") && Contains("baked again"));
    const BakedShape cached = bake_object(object, kPlenty);
    CHECK(cached.report.from_cache);
    CHECK(same_shape(cached, fresh));
  }
}

TEST_CASE("bake: a cache folder that cannot be written is said and does no harm") {
  const Bench bench;
  const std::string blocked = bench.write("blocked", "a file where a folder should be");
  const Environment cache("HAPTICD_CACHE", blocked);
  const ObjectConfig object = object_at(bench.write("b.off", as_off(make_box({1, 1, 1}))));
  const BakedShape baked = bake_object(object, kPlenty);
  CHECK(baked.shape.mesh.closed);
  REQUIRE(baked.report.lines.size() == 1);
  CHECK_THAT(baked.report.lines[0], Contains(blocked) && Contains("set HAPTICD_CACHE"));
}

TEST_CASE("bake: primitives are baked from their parameters") {
  ObjectConfig box;
  box.primitive = primitive::Box{{0.1, 0.2, 0.3}};
  const BakedShape b = bake_object(box, kPlenty);
  CHECK(b.shape.mesh.closed);
  CHECK_THAT(b.shape.mesh.upper, IsNear({0.05, 0.1, 0.15}, kLengthTolerance));
  CHECK(first_hit(b.shape, {1, 0, 0}, {0, 0, 0}).t == Approx(0.95));

  ObjectConfig sphere;
  sphere.primitive = primitive::Sphere{0.1, 3};
  const BakedShape s = bake_object(sphere, kPlenty);
  CHECK(s.shape.mesh.triangles.size() == 1280);
  CHECK(s.report.size == Approx(0.1).epsilon(0.01));
}

TEST_CASE("bake: the mesh for the eye is light and keeps the shape") {
  // 81,920 triangles, of which three in four must go
  const uint32_t subdivisions = kSlowdown > 1 ? 4 : 6;
  const BakedShape fine = bake(make_icosphere(0.05, subdivisions));
  CHECK(fine.eye_triangles.size() <= 20000);
  CHECK(fine.eye_triangles.size() > 4000);
  REQUIRE(fine.eye_normals.size() == fine.eye_vertices.size());
  for (size_t i = 0; i < fine.eye_vertices.size(); ++i) {
    // a facet of 20 000 is half a degree across
    REQUIRE(std::fabs(norm(fine.eye_vertices[i]) - 0.05) < 1e-4);
    REQUIRE(dot(fine.eye_normals[i], normalized(fine.eye_vertices[i])) > 0.99);
  }
}

TEST_CASE("bake: meshes from the field are read and what is wrong with them is said") {
  const Bench bench;
  for (const char* name : {"bunny00.off", "couplingdown.off", "bones.off", "pig.stl"}) {
    const auto path = find_mesh(name);
    if (!path || (kSlowdown > 1 && std::string(name) == "bunny00.off")) continue;
    ObjectConfig object = object_at(*path);
    object.unit = 0;
    object.size = 0.1;
    object.allow_open = 1;
    CAPTURE(name);
    const BakedShape baked = bake_object(object, kPlenty);
    CHECK(baked.report.size == Approx(0.1));
    CHECK(baked.shape.mesh.closed == baked.report.closed);
    CHECK((baked.report.closed && baked.report.self_intersections == 0) !=
          !baked.report.lines.empty());
  }
}

TEST_CASE("bake: a pipe in the place of a mesh is refused, and nobody waits") {
  const Bench bench;
  const std::string pipe = bench.folder.path() + "/pipe.off";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  CHECK_THROWS_WITH(bake_object(object_at(pipe), kPlenty), pipe + ": is a pipe; check the path");
}

TEST_CASE("bake: a pipe in the place of a cache is no cache, and nobody waits") {
  const Bench bench;
  const std::string path = bench.folder.path() + "/s.off";
  std::ofstream(path, std::ios::binary) << as_off(make_icosphere(0.05, 2));
  const ObjectConfig object = object_at(path);
  bake_object(object, kPlenty);
  const std::filesystem::path cached = *std::filesystem::directory_iterator(bench.cache);
  std::filesystem::remove(cached);
  REQUIRE(::mkfifo(cached.c_str(), 0600) == 0);
  const BakedShape again = bake_object(object, kPlenty);
  CHECK_FALSE(again.report.from_cache);
  CHECK_THAT(again.report.lines.back(),
             Contains("unusable (it is no file)") && Contains("baked again"));
  CHECK(bake_object(object, kPlenty).report.from_cache);
}

TEST_CASE("bake: a machine without enough memory is told so, with the mesh and the remedy") {
  if (kSlowdown > 1) return;  // a sanitizer reserves more address space than there is
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    const rlimit limit{256 << 20, 256 << 20};
    ::setrlimit(RLIMIT_AS, &limit);
    ObjectConfig object;
    object.primitive = primitive::Sphere{0.1, 8};
    try {
      bake_object(object, kPlenty);
      ::_exit(1);
    } catch (const MeshError& error) {
      ::_exit(std::string(error.what()).find("not enough memory") != std::string::npos ? 0 : 2);
    } catch (...) {  // in a forked child: the exit code reports any other exception
      ::_exit(3);
    }
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
}
