// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/tree/hash_grid.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <set>

#include "contact/bake/grid.h"
#include "contact/query/point/segment_hit.h"
#include "contact/shape/mesh/mesh_topology.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

MeshShapeData with_cells(MeshShapeData shape, double cell) {
  shape.grid = build_hash_grid(shape.mesh.view(), shape.tree.view(), cell);
  return shape;
}

/// The triangles of a cell, from its batches or below its roots.
std::set<uint32_t> held(const MeshShape& shape, const GridCell& cell) {
  std::set<uint32_t> triangles;
  for (const TriangleBatch& batch : cell.batches) {
    for (size_t i = 0; i < kBatch; ++i) {
      if (batch.is_used(i)) triangles.insert(batch.triangle[i]);
    }
  }
  std::vector<uint32_t> open(cell.roots.begin(), cell.roots.end());
  while (!open.empty()) {
    const ObbNode& node = shape.tree.nodes[open.back()];
    open.pop_back();
    if (node.count == 0) open.insert(open.end(), {node.first, node.first + 1u});
    for (uint32_t k = 0; k < node.count; ++k) triangles.insert(shape.tree.order[node.first + k]);
  }
  return triangles;
}

uint64_t key_at(const HashGrid& grid, const Vec3& p_O) {
  const Vec3 c = grid.cells_per_metre * (p_O - grid.lower_O);
  return cell_key(
      {static_cast<int32_t>(c.x), static_cast<int32_t>(c.y), static_cast<int32_t>(c.z)});
}

/// Every point of every triangle lies in a cell that holds the triangle.
void check_cover(const MeshShapeData& shape, uint64_t seed, size_t n) {
  Random random(seed);
  const MeshShape view = shape.view();
  REQUIRE_FALSE(view.grid.slots.empty());
  for (size_t i = 0; i < n; ++i) {
    const auto t = static_cast<uint32_t>(random.index(view.mesh.triangles.size()));
    double u = random.uniform(0, 1), v = random.uniform(0, 1);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const auto& [a, b, c] = view.mesh.triangles[t];
    const Vec3 p = view.mesh.vertices[a] + u * (view.mesh.vertices[b] - view.mesh.vertices[a]) +
                   v * (view.mesh.vertices[c] - view.mesh.vertices[a]);
    CAPTURE(t, p);
    REQUIRE(held(view, view.grid.find(key_at(view.grid, p))).count(t) == 1);
  }
}

/// The cells find what the tree finds.
void same_by_cells(const MeshShape& shape, const Vec3& from, const Vec3& to) {
  MeshShape without_grid = shape;
  without_grid.grid = {};
  const SegmentHit tree = first_hit(without_grid, from, to), cells = first_hit(shape, from, to);
  CAPTURE(from, to, tree.t, tree.triangle, cells.t, cells.triangle);
  REQUIRE(cells.hit == tree.hit);
  if (!tree.hit) return;
  REQUIRE(cells.t == tree.t);
  REQUIRE(cells.triangle == tree.triangle);
}

}  // namespace

TEST_CASE("hash grid: each cell that a triangle reaches into holds it") {
  for (const double edges : {0.4, 1.0, 3.0, 30.0}) {
    CAPTURE(edges);
    for (const Soup& soup : {make_icosphere(0.05, 3), make_grid(0.05, 12),
                             make_box({0.1, 0.2, 0.3}), make_degenerate_soup(1, 300)}) {
      const MeshShapeData shape = build_shape(soup);
      check_cover(with_cells(shape, edges * mean_edge_length(shape.mesh.view())), 2, trials(2000));
    }
  }
}

TEST_CASE("hash grid: crowded cells hold subtrees, and nothing is lost") {
  const MeshShapeData shape = build_shape(make_icosphere(0.05, 4));
  const MeshShapeData coarse = with_cells(shape, 0.05);
  CHECK_FALSE(coarse.grid.roots.empty());
  CHECK(coarse.grid.roots.size() < shape.mesh.triangles.size() / 4);
  check_cover(coarse, 3, trials(2000));
}

TEST_CASE("hash grid: two cells with the same slot are told apart") {
  const MeshShapeData shape = build_shape(make_icosphere(0.05, 4));
  const HashGrid grid = shape.grid.view();
  size_t displaced = 0;
  for (size_t i = 0; i < grid.slots.size(); ++i) {
    const GridSlot& slot = grid.slots[i];
    if (slot.count == 0) continue;
    displaced += first_slot(slot.key, grid.slots.size()) != i;
    REQUIRE(grid.find(slot.key).batches.data() == &grid.batches[slot.first]);
    // another cell whose search begins at the same slot
    uint64_t other = slot.key + 1;
    while (first_slot(other, grid.slots.size()) != first_slot(slot.key, grid.slots.size())) ++other;
    const GridCell found = grid.find(other);
    REQUIRE(found.batches.data() != &grid.batches[slot.first]);
  }
  CHECK(displaced > 0);
}

TEST_CASE("hash grid: the size of the cells changes no hit") {
  Random random(4);
  const MeshShapeData shape = build_shape(make_icosphere(0.05, 4));
  const double edge = mean_edge_length(shape.mesh.view());
  std::vector<MeshShapeData> shapes;
  for (const double edges : {0.3, 0.7, 1.0, 1.5, 2.0, 5.0, 20.0}) {
    shapes.push_back(with_cells(shape, edges * edge));
  }
  for (size_t i = 0; i < trials(600); ++i) {
    const Vec3 from = random.on_surface(shape.mesh.view()) + 0.003 * random.direction();
    const Vec3 to = from + random.uniform(0, 0.02) * random.direction();
    for (const MeshShapeData& other : shapes) same_by_cells(other.view(), from, to);
  }
}

TEST_CASE("hash grid: a walk along axes, along faces of cells and through their corners") {
  // cells of 1/4 aligned with the lattice of the mesh, also on the negative side
  MeshShapeData shape = build_shape(make_grid(2, 16));
  for (Vec3& v : shape.mesh.vertices) v.z = 0.125 * std::round(8 * std::sin(3 * v.x + 2 * v.y));
  shape = build_shape({shape.mesh.vertices, shape.mesh.triangles});
  shape = with_cells(shape, 0.25);
  const MeshShape view = shape.view();
  const Vec3 corner = view.grid.lower_O;
  Random random(5);
  for (size_t i = 0; i < trials(3000); ++i) {
    const auto lattice = [&] { return 0.25 * std::floor(random.uniform(-12, 12)); };
    const Vec3 from{lattice(), lattice(), corner.z + 0.25 * std::floor(random.uniform(14, 30))};
    Vec3 to = from;
    const int axis = static_cast<int>(i % 3);
    to[axis] += lattice();
    // along one axis, in a face of the cells, or through corner after corner
    if (i % 4 == 1) to[(axis + 1) % 3] += lattice();
    if (i % 4 >= 2) to += lattice() * Vec3{1, i % 8 >= 4 ? 1.0 : -1.0, i % 16 >= 8 ? 1.0 : -1.0};
    same_by_cells(view, from, to);
    same_by_cells(view, to, from);
  }
}

TEST_CASE("hash grid: segments outside the grid, into it from far, of no length") {
  const MeshShapeData shape = build_shape(make_icosphere(0.05, 3));
  const MeshShape view = shape.view();
  CHECK_FALSE(first_hit(view, {1, 1, 1}, {1.001, 1, 1}).hit);
  CHECK_FALSE(first_hit(view, {-1, -1, -1}, {-1.001, -1, -1}).hit);
  CHECK_FALSE(first_hit(view, {1e300, 0, 0}, {1e300, 1, 0}).hit);
  CHECK_FALSE(first_hit(view, {0.05, 0, 0}, {0.05, 0, 0}).hit);
  CHECK(first_hit(view, {1e3, 1e-4, 1e-4}, {0, 1e-4, 1e-4}).hit);
  CHECK(first_hit(view, {-1e6, 1e-4, 1e-4}, {1e6, 1e-4, 1e-4}).hit);
  same_by_cells(view, {-1e6, 1e-4, 1e-4}, {1e6, 1e-4, 1e-4});
}

TEST_CASE("hash grid: where cells cannot be counted there is no grid, and queries take the tree") {
  const MeshShapeData shape = build_shape(make_icosphere(0.05, 2));
  for (const double cell : {0.0, -1.0, 1e-9, std::nan("")}) {
    CHECK(with_cells(shape, cell).grid.slots.empty());
  }
  CHECK(first_hit(with_cells(shape, 0).view(), {1, 1e-3, 0}, {0, 1e-3, 0}).hit);
  // a huge triangle among small ones would need too many cells
  Soup mixed = make_icosphere(1e-4, 4);
  const auto first = static_cast<uint32_t>(mixed.vertices.size());
  mixed.vertices.insert(mixed.vertices.end(), {{-1, -1, -1}, {1, 1, -1}, {0, 1, 1}});
  mixed.triangles.push_back({first, first + 1, first + 2});
  const MeshData mesh = build_mesh(mixed.vertices, mixed.triangles);
  CHECK(build_hash_grid(mesh.view(), build_obb_tree(mesh.view()).view(), 1e-5).slots.empty());
  CHECK(build_hash_grid({}, {}, 1).slots.empty());
}

TEST_CASE("hash grid: it is the same on one thread and in pieces run in the other order") {
  const MeshData mesh =
      build_mesh(make_icosphere(0.05, 6).vertices, make_icosphere(0.05, 6).triangles);
  const auto reversed = [](const auto& first, const auto& second) { second(), first(); };
  const ObbTreeData tree = build_obb_tree(mesh.view()),
                    other_tree = build_obb_tree(mesh.view(), reversed);
  REQUIRE(tree.order == other_tree.order);
  REQUIRE(std::memcmp(tree.nodes.data(), other_tree.nodes.data(),
                      tree.nodes.size() * sizeof(ObbNode)) == 0);
  const HashGridData grid = build_hash_grid(mesh.view(), tree.view(), 1e-3),
                     other = build_hash_grid(mesh.view(), tree.view(), 1e-3, reversed);
  REQUIRE(grid.batches.size() == other.batches.size());
  REQUIRE(std::memcmp(grid.batches.data(), other.batches.data(),
                      grid.batches.size() * sizeof(TriangleBatch)) == 0);
}

TEST_CASE(
    "hash grid: the cells are the cheapest that keep to the memory, and take what is expected") {
  constexpr double kMost = 54;  // bytes a triangle
  const MeshShapeData shape = build_shape(make_icosphere(0.05, 5));
  const TriangleMesh mesh = shape.mesh.view();
  const auto n = static_cast<double>(mesh.triangles.size());
  const double chosen = choose_cell(mesh);
  const std::vector<CellSize> sizes = weigh_cells(mesh);
  REQUIRE(sizes.size() > 8);
  const auto best = std::find_if(sizes.begin(), sizes.end(),
                                 [&](const CellSize& size) { return size.cell == chosen; });
  REQUIRE(best != sizes.end());
  CHECK(best->bytes <= kMost);
  for (const CellSize& size : sizes) {
    CHECK((size.bytes > kMost || size.cost >= best->cost));
    if (size.cell > 0.01) continue;  // crowded cells behave differently
    const HashGridData grid = with_cells(shape, size.cell).grid;
    const auto bytes = static_cast<double>(grid.slots.size() * sizeof(GridSlot) +
                                           grid.batches.size() * sizeof(TriangleBatch));
    CAPTURE(size.cell, bytes / n);
    CHECK(size.bytes == Approx(bytes / n).epsilon(0.35));
  }
  // all of a box is in one cell
  CHECK(choose_cell(build_shape(make_box({{0.1, 0.1, 0.1}})).mesh.view()) > 1);
  CHECK(choose_cell({}) == 0);
}
