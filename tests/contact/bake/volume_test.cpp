// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/volume.h"

#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "contact/shape/mesh/mass_properties.h"
#include "contact/shape/parts/machine_parts.h"
#include "tests/support/hostile_text.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"
#include "tests/support/temporary_folder.h"

using namespace haptic;
using namespace haptic::test;
using Catch::Matchers::Contains;

namespace {

struct Cache {
  TemporaryCache folder;
  std::vector<std::filesystem::path> files() const {
    std::vector<std::filesystem::path> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
      found.push_back(entry.path());
    }
    return found;
  }
};

BakedShape baked_volume(const Soup& soup, bool allow_open = false) {
  ShapeConfig object;
  assign(object.name, "thing");
  object.allow_open = allow_open;
  return bake_soup(soup.vertices, soup.triangles, object);
}

Soup open_box() {
  Soup box = make_box({0.04, 0.04, 0.02});
  box.triangles.resize(10);
  return box;
}

VoxelConfig coarse() {
  VoxelConfig options;
  options.size = options.point_spacing = 2e-3;
  options.band = 6e-3;
  return options;
}

template <class T>
bool same(std::span<const T> a, std::span<const T> b) {
  return a.size_bytes() == b.size_bytes() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

bool same_content(const VolumeContent& a, const VolumeContent& b) {
  return a.map.lower_O == b.map.lower_O && a.map.size == b.map.size &&
         a.map.bricks == b.map.bricks && same(a.map.index, b.map.index) &&
         same(a.map.data, b.map.data) && a.field.lower_O == b.field.lower_O &&
         a.field.cell == b.field.cell && a.field.band == b.field.band &&
         a.field.bricks == b.field.bricks && same(a.field.index, b.field.index) &&
         same(a.field.middle, b.field.middle) && same(a.field.data, b.field.data) &&
         a.shell.spacing == b.shell.spacing && a.shell.radius == b.shell.radius &&
         same(a.shell.x, b.shell.x) && same(a.shell.nz, b.shell.nz) &&
         same(a.shell.nodes, b.shell.nodes) && same(a.shell.levels, b.shell.levels);
}

std::string refused(const std::function<void()>& work) {
  std::string error = refusal<MeshError>(work);
  CHECK(error.find('\n') == std::string::npos);
  return error;
}

}  // namespace

TEST_CASE("bake volume: the cache gives back the same map, field and shell") {
  const Cache cache;
  const BakedShape shape = baked_volume(make_icosphere(0.02, 3));
  const BakedVolume obstacle = bake_obstacle(shape, coarse()), tool = bake_tool(shape, coarse());
  CHECK_FALSE(obstacle.from_cache);
  CHECK_FALSE(tool.from_cache);
  CHECK(cache.files().size() == 2);
  CHECK(obstacle.content.map.at(obstacle.content.map.index_of({})) == Voxel::kInterior);
  CHECK(tool.content.shell.x.size() > 500);
  const BakedVolume again = bake_obstacle(shape, coarse()), held = bake_tool(shape, coarse());
  CHECK(again.from_cache);
  CHECK(held.from_cache);
  CHECK(again.content.map.voxels_per_metre == obstacle.content.map.voxels_per_metre);
  CHECK(same_content(again.content, obstacle.content));
  CHECK(same_content(held.content, tool.content));
  CHECK(again.lines.empty());
}

TEST_CASE("bake volume: each option that matters is another entry, the others are not") {
  const Cache cache;
  const BakedShape shape = baked_volume(make_box({0.02, 0.02, 0.02}));
  bake_obstacle(shape, coarse());
  VoxelConfig other = coarse();
  other.stiffness = 5, other.budget = 7, other.point_spacing = 1e-3;
  CHECK(bake_obstacle(shape, other).from_cache);
  const std::vector<std::function<void(VoxelConfig&)>> changes{
      [](VoxelConfig& v) { v.size = 1.9e-3; }, [](VoxelConfig& v) { v.offset_layers = 1; },
      [](VoxelConfig& v) { v.field = 0; }, [](VoxelConfig& v) { v.band = 5e-3; }};
  for (const auto& change : changes) {
    VoxelConfig changed = coarse();
    change(changed);
    CHECK_FALSE(bake_obstacle(shape, changed).from_cache);
    CHECK(bake_obstacle(shape, changed).from_cache);
  }
  CHECK_FALSE(bake_obstacle(baked_volume(make_box({0.02, 0.02, 0.021})), coarse()).from_cache);
}

TEST_CASE("bake volume: the field of a sphere is its distance, the map has none without one") {
  const Cache cache;
  constexpr double kRadius = 0.02;
  const BakedShape shape = baked_volume(make_icosphere(kRadius, 4));
  std::vector<double> shares;
  const BakedVolume baked = bake_obstacle(shape, coarse(), [&](std::string_view what, double s) {
    if (what == "distance field") shares.push_back(s);
  });
  REQUIRE(shares.size() > 1);
  CHECK(shares.front() == 0);
  CHECK(shares.back() == 1);
  CHECK(std::is_sorted(shares.begin(), shares.end()));
  // errors of the facets and of the interpolation in a cell
  const double facet = 1e-4, cell = 0.5 * 2e-3 * 2e-3 / (kRadius - 6e-3);
  Random random(1);
  for (size_t i = 0; i < trials(5000); ++i) {
    const double distance = random.uniform(-4e-3, 4e-3);
    const FieldSample s =
        sample_field(baked.content.field, (kRadius + distance) * random.direction());
    REQUIRE(s.is_near);
    REQUIRE(std::fabs(s.distance - distance) < facet + cell);
  }
  VoxelConfig map_alone = coarse();
  map_alone.field = 0;
  CHECK(bake_obstacle(shape, map_alone).content.field.index.empty());
}

TEST_CASE("bake volume: an open mesh has no inside, is refused, and is a sheet on request") {
  const Cache cache;
  const BakedShape shape = baked_volume(open_box(), true);
  CHECK_THAT(refused([&] { bake_obstacle(shape, coarse()); }),
             Contains("thing") && Contains("not closed (4 border edges)") &&
                 Contains("no inside") && Contains("fill its holes") &&
                 Contains("open_as_sheet = true"));
  CHECK(cache.files().empty());
  VoxelConfig sheet = coarse();
  sheet.open_as_sheet = 1;
  sheet.offset_layers = 0;
  const BakedVolume baked = bake_obstacle(shape, sheet);
  CHECK(baked.content.map.at(baked.content.map.index_of({})) != Voxel::kInterior);
  // the bottom, from either side: half a voxel thicker
  for (const double side : {-1.0, 1.0}) {
    const FieldSample s = sample_field(baked.content.field, {1e-3, 2e-3, -0.01 + side * 2e-3});
    CHECK(s.is_near);
    CHECK(s.distance == Approx(2e-3 - 1e-3).margin(0.2e-3));
  }
}

TEST_CASE("bake volume: too many voxels are refused with the size that would do") {
  const Cache cache;
  const BakedShape shape = baked_volume(make_box({0.1, 0.01, 0.01}));
  VoxelConfig fine = coarse();
  fine.size = 1e-5;
  CHECK_THAT(refused([&] { bake_obstacle(shape, fine); }),
             Contains("10000 voxels") && Contains("4096") && Contains("0.0244 mm or more"));
}

TEST_CASE("bake volume: a damaged cache is said and baked again") {
  const Cache cache;
  const BakedShape shape = baked_volume(make_box({0.02, 0.02, 0.02}));
  const BakedVolume fresh = bake_obstacle(shape, coarse());
  REQUIRE(cache.files().size() == 1);
  const std::filesystem::path file = cache.files()[0];
  std::ifstream in(file, std::ios::binary);
  const std::string good{std::istreambuf_iterator<char>(in), {}};
  for (const size_t place : {size_t{9}, size_t{17}, good.size() / 4, 3 * good.size() / 4}) {
    std::string bad = good;
    bad[place] = static_cast<char>(bad[place] ^ 4);
    std::filesystem::remove(file);
    std::ofstream(file, std::ios::binary) << bad;
    const BakedVolume again = bake_obstacle(shape, coarse());
    CHECK_FALSE(again.from_cache);
    REQUIRE(again.lines.size() == 1);
    CHECK_THAT(again.lines[0], Contains("unusable") && Contains("baked again"));
    CHECK(same_content(again.content, fresh.content));
    CHECK(bake_obstacle(shape, coarse()).from_cache);
  }
}

TEST_CASE("baked volume: every damaged section is refused even with a right checksum") {
  const MeshShapeData box = build_shape(make_box({0.02, 0.02, 0.02}));
  const TriangleMesh mesh = box.mesh.view();
  struct Data {
    VoxmapData map;
    DistanceFieldData field;
    PointshellData shell;
  };
  const Data good{
      build_voxmap(mesh, {2e-3, 1}),
      build_distance_field(mesh.lower, mesh.upper, [](const Vec3& p) { return norm(p) - 0.01; },
                           {2e-3, 4e-3, 4e-3}),
      build_pointshell(mesh, 2e-3)};
  const auto refused = [](const Data& d) {
    const auto bytes = write_volume({d.map.view(), d.field.view(), d.shell.view()}, 7);
    try {
      view_volume(bytes, 7);
      return false;
    } catch (const BakedFileError&) {
      return true;
    }
  };
  CHECK_FALSE(refused(good));
  CHECK_FALSE(refused({}));
  const std::vector<std::function<void(Data&)>> breaks{
      [](Data& d) { d.map.index[1] = 1u << 20; }, [](Data& d) { d.map.index.pop_back(); },
      [](Data& d) { d.map.index.clear(); }, [](Data& d) { d.map.data.resize(1); },
      [](Data& d) { d.map.bricks[1] = -d.map.bricks[1]; },
      [](Data& d) {
        d.map.bricks = {1 << 30, 1 << 30, 1 << 30};
      },
      [](Data& d) { d.map.size = std::nan(""); }, [](Data& d) { d.map.lower_O.y = std::nan(""); },
      [](Data& d) { d.field.index[0] = 1u << 20; }, [](Data& d) { d.field.index.pop_back(); },
      [](Data& d) { d.field.middle.pop_back(); }, [](Data& d) { d.field.bricks[2] = 0; },
      [](Data& d) { d.field.cell = 0; }, [](Data& d) { d.field.band = std::nan(""); },
      [](Data& d) { d.shell.y.pop_back(); }, [](Data& d) { d.shell.nz.push_back(0); },
      [](Data& d) { d.shell.levels.pop_back(); }, [](Data& d) { d.shell.levels[0] = 1; },
      [](Data& d) { d.shell.levels[1] = 2; }, [](Data& d) { d.shell.nodes[0].n_children += 1; },
      [](Data& d) { d.shell.nodes[0].first_child = 0; },
      [](Data& d) { d.shell.nodes[1].first_child = 1u << 20; },
      [](Data& d) { d.shell.nodes[0].count = 1u << 20; },
      [](Data& d) { d.shell.nodes[0].point = 1u << 20; },
      [](Data& d) { d.shell.nodes[0].radius = std::nanf(""); },
      // a search has space for the points of a node two levels above them, at most 8²
      [](Data& d) { d.shell.nodes[d.shell.levels[d.shell.levels.size() - 4]].count = 65; },
      // a node with two parents would be visited twice
      [](Data& d) { d.shell.nodes[2].first_child = d.shell.nodes[1].first_child; },
      [](Data& d) { d.shell.nodes.back().n_children = 1; }};
  for (size_t i = 0; i < breaks.size(); ++i) {
    CAPTURE(i);
    Data bad = good;
    breaks[i](bad);
    CHECK(refused(bad));
  }
  const auto volume = write_volume({good.map.view(), {}, {}}, 7);
  CHECK_THROWS_AS(view_volume(volume, 8), BakedFileError);
  // a file of the other kind
  CHECK_THROWS_AS(view_block(volume, BakedKind::kShape, 7, 14), BakedFileError);
}

TEST_CASE("bake: parts of machines are closed and as large as they are said to be") {
  ShapeConfig gear;
  gear.primitive = primitive::Gear{.teeth = 12, .grid = {288, 2}};
  const BakedShape baked = bake_object(gear, uint64_t{4} << 30);
  CHECK(baked.shape.mesh.closed);
  CHECK(baked.report.lines.empty());
  CHECK(baked.report.size == Approx(3e-3 * 14).epsilon(1e-3));
  const PartGrid grid{24, 64};
  const primitive::Thread thread{.depth = 1e-3, .grid = grid};
  for (const Primitive& made :
       std::vector<Primitive>{primitive::Peg{.grid = grid}, primitive::Hole{{.grid = grid}, 1e-4},
                              primitive::Bolt{thread}, primitive::Nut{thread, 1e-4, 0.016, 0.03}}) {
    ShapeConfig part;
    part.primitive = made;
    CAPTURE(kind_name(made));
    const BakedShape shape = bake_object(part, uint64_t{4} << 30);
    CHECK(shape.shape.mesh.closed);
    CHECK(shape.report.self_intersections == 0);
  }
}

TEST_CASE("mass properties: box, ball and bored block in closed form, wherever they lie") {
  const Vec3 side{0.1, 0.2, 0.3}, at{3, -2, 1};
  Soup box = make_box({side});
  for (Vec3& v : box.vertices) v += at;
  const MassProperties b = mass_properties(build_mesh(box.vertices, box.triangles).view());
  const double volume = side.x * side.y * side.z;
  CHECK(b.volume == Approx(volume));
  CHECK_THAT(b.centre_O, IsNear(at, 1e-12));
  CHECK(b.inertia_O.row[0].x == Approx(volume / 12 * (0.04 + 0.09)));
  CHECK(b.inertia_O.row[1].y == Approx(volume / 12 * (0.01 + 0.09)));
  CHECK(b.inertia_O.row[2].z == Approx(volume / 12 * (0.01 + 0.04)));
  CHECK(std::fabs(b.inertia_O.row[0].y) < 1e-12 * volume);

  constexpr double kRadius = 0.05;
  const Soup ball = make_icosphere(kRadius, 5);
  const MassProperties s = mass_properties(build_mesh(ball.vertices, ball.triangles).view());
  CHECK(s.inertia_O.row[2].z == Approx(0.4 * s.volume * kRadius * kRadius).epsilon(2e-3));

  // a block with a hole: the inertia of the hole is subtracted
  const primitive::Hole fit{{.grid = {400, 1}}};
  const Soup block = make_hole(fit);
  const MassProperties h = mass_properties(build_mesh(block.vertices, block.triangles).view());
  const double r = 0.5 * fit.diameter + fit.clearance, a = fit.block;
  const double about_axis =
      fit.length * (a * a * a * a / 6 - 0.5 * 3.14159265358979 * r * r * r * r);
  CHECK(h.inertia_O.row[2].z == Approx(about_axis).epsilon(1e-3));
  CHECK(mass_properties({}).volume == 0);
}
