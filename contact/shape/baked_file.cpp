// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/baked_file.h"

#include <xxhash.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <string>

namespace haptic {
namespace {

constexpr std::array<char, 8> kMagic{'h', 'a', 'p', 't', 'b', 'a', 'k', 'e'};
constexpr size_t kAlignment = 64;
constexpr size_t kSections = 19;

struct Section {
  uint64_t offset = 0, count = 0;
};

struct Header {
  std::array<char, 8> magic = kMagic;
  uint32_t version = kBakeVersion;
  uint32_t header_bytes = sizeof(Header);
  uint64_t file_bytes = 0;
  uint64_t key = 0;
  std::array<uint64_t, 2> checksums{};  // of each half of the file, with this field zero
  Vec3 lower, upper;
  uint64_t closed = 0;
  Vec3 grid_lower;
  double cell = 0;
  std::array<Section, kSections> sections;
};
static_assert(std::is_trivially_copyable_v<Header>);

/// Calls f on each array, in the order of the file.
template <class Content, class F>
void for_each_section(Content& content, F&& f) {
  auto& mesh = content.shape.mesh;
  f(mesh.vertices), f(mesh.triangles), f(mesh.face_normals), f(mesh.triangle_edges);
  f(mesh.edge_faces), f(mesh.vertex_valence), f(mesh.edge_normals), f(mesh.vertex_normals);
  f(content.shape.tree.nodes), f(content.shape.tree.order);
  f(content.shape.grid.slots), f(content.shape.grid.batches), f(content.shape.grid.roots);
  f(content.shape.patches.nodes), f(content.shape.patches.leaves);
  f(content.eye_vertices), f(content.eye_normals), f(content.eye_triangles), f(content.notes);
}

size_t aligned(size_t n) {
  return (n + kAlignment - 1) / kAlignment * kAlignment;
}

/// Of the first half, which the header begins, and of the second.
uint64_t first_checksum(Header header, std::span<const std::byte> file) {
  header.checksums = {};
  const auto rest = file.first(std::max(sizeof header, file.size() / 2)).subspan(sizeof header);
  return hash_bytes(rest, hash_bytes(std::as_bytes(std::span(&header, 1))));
}
uint64_t second_checksum(std::span<const std::byte> file) {
  return hash_bytes(file.subspan(std::max(sizeof(Header), file.size() / 2)));
}

void require(bool holds, const char* what) {
  if (!holds) throw BakedFileError(what);
}

Header read_header(std::span<const std::byte> bytes, uint64_t key) {
  Header header;
  require(bytes.size() >= sizeof header, "shorter than its header");
  std::memcpy(&header, bytes.data(), sizeof header);
  require(header.magic == kMagic, "not a baked shape");
  require(header.version == kBakeVersion && header.header_bytes == sizeof header,
          "baked by another version");
  require(header.key == key, "baked from something else");
  require(header.file_bytes == bytes.size(), "truncated");
  return header;
}

template <class T>
std::span<const T> view_section(std::span<const std::byte> bytes, const Section& section) {
  require(section.offset <= bytes.size() && section.offset % alignof(T) == 0 &&
              section.count <= (bytes.size() - section.offset) / sizeof(T),
          "an array outside the file");
  return {reinterpret_cast<const T*>(bytes.data() + section.offset), section.count};
}

template <class Rows>
bool all_below(const Rows& rows, size_t limit) {
  return std::all_of(rows.begin(), rows.end(), [&](const auto& row) {
    return std::all_of(row.begin(), row.end(), [&](uint32_t i) { return i < limit; });
  });
}

void check_mesh(const TriangleMesh& mesh) {
  const size_t n_faces = mesh.triangles.size(), n_edges = mesh.edge_faces.size();
  require(mesh.face_normals.size() == n_faces && mesh.triangle_edges.size() == n_faces &&
              mesh.edge_normals.size() == n_edges &&
              mesh.vertex_normals.size() == mesh.vertices.size() &&
              mesh.vertex_valence.size() == mesh.vertices.size(),
          "arrays of different lengths");
  require(
      all_below(mesh.triangles, mesh.vertices.size()) && all_below(mesh.triangle_edges, n_edges) &&
          std::all_of(
              mesh.edge_faces.begin(), mesh.edge_faces.end(),
              [&](const auto& f) { return f[0] < n_faces && (f[1] < n_faces || f[1] == kNoFace); }),
      "an index out of range");
}

void check_tree(const ObbTree& tree, size_t n_faces) {
  require(tree.order.size() == n_faces && tree.nodes.empty() == (n_faces == 0),
          "a tree of another mesh");
  require(
      std::all_of(tree.order.begin(), tree.order.end(), [&](uint32_t i) { return i < n_faces; }),
      "a triangle out of range in the tree");
  // children come after their parent: no cycles, and depths in one pass
  std::vector<int> depth(tree.nodes.size(), 0);
  for (size_t i = 0; i < tree.nodes.size(); ++i) {
    const ObbNode& node = tree.nodes[i];
    if (node.count > 0) {
      require(node.first <= n_faces && node.count <= n_faces - node.first, "a leaf out of range");
      continue;
    }
    require(
        node.first > i && uint64_t{node.first} + 1 < tree.nodes.size() && depth[i] < kMaxTreeDepth,
        "a broken tree");
    for (const size_t child : {size_t{node.first}, size_t{node.first} + 1}) {
      depth[child] = std::max(depth[child], depth[i] + 1);
    }
  }
}

void check_grid(const HashGrid& grid, size_t n_faces, size_t n_nodes) {
  if (grid.slots.empty()) return;
  require(std::has_single_bit(grid.slots.size()) && grid.cell > 0 && std::isfinite(grid.cell) &&
              std::isfinite(grid.cells_per_metre) && is_finite(grid.lower_O) && n_nodes > 0,
          "a broken grid");
  size_t n_free = 0;
  for (const GridSlot& slot : grid.slots) {
    const size_t limit = slot.is_crowded ? grid.roots.size() : grid.batches.size();
    require(slot.first <= limit && slot.count <= limit - slot.first &&
                (slot.is_crowded || slot.count <= kCrowded / kBatch),
            "a cell out of range");
    n_free += slot.count == 0;
  }
  // a search ends at a free slot
  require(n_free > 0, "a grid without a free slot");
  require(
      std::all_of(grid.roots.begin(), grid.roots.end(), [&](uint32_t i) { return i < n_nodes; }) &&
          std::all_of(grid.batches.begin(), grid.batches.end(),
                      [&](const TriangleBatch& batch) {
                        return std::all_of(batch.triangle.begin(), batch.triangle.end(),
                                           [&](uint32_t t) { return t < n_faces; });
                      }),
      "a triangle out of range in the grid");
}

void check_patches(const PatchTree& patches, const TriangleMesh& mesh) {
  require(patches.nodes.empty() == mesh.triangles.empty(), "patches of another mesh");
  std::vector<int> depth(patches.nodes.size(), 0);
  for (size_t i = 0; i < patches.nodes.size(); ++i) {
    const PatchNode& node = patches.nodes[i];
    for (size_t lane = 0; lane < kPatchLanes; ++lane) {
      const uint32_t child = node.child[lane];
      if (child == kNoPatch) continue;
      if ((child & kPatchLeaf) != 0) {
        require((child & ~kPatchLeaf) < patches.leaves.size(), "a patch out of range");
        continue;
      }
      // children come after their one parent: no cycles, and depths in one pass
      require(child > i && child < patches.nodes.size() && depth[child] == 0 &&
                  depth[i] + 1 < kMaxPatchDepth,
              "broken patches");
      depth[child] = depth[i] + 1;
    }
    require(i == 0 || depth[i] > 0, "a patch without parent");
  }
  for (const PatchLeaf& leaf : patches.leaves) {
    for (size_t k = 0; k < kPatchLanes; ++k) {
      require(leaf.triangle[k] == kNoFace || leaf.triangle[k] < mesh.triangles.size(),
              "a triangle out of range in a patch");
    }
  }
}

void check_eye(const BakedContent& content) {
  require(content.eye_normals.size() == content.eye_vertices.size() &&
              all_below(content.eye_triangles, content.eye_vertices.size()),
          "an index out of range in the mesh for the eye");
}

}  // namespace

uint64_t hash_bytes(std::span<const std::byte> bytes, uint64_t seed) {
  return XXH3_64bits_withSeed(bytes.data(), bytes.size(), seed);
}

std::vector<std::byte> write_baked(const BakedContent& content, uint64_t key) {
  Header header;
  header.key = key;
  header.lower = content.shape.mesh.lower;
  header.upper = content.shape.mesh.upper;
  header.closed = content.shape.mesh.closed;
  header.grid_lower = content.shape.grid.lower_O;
  header.cell = content.shape.grid.cell;
  size_t end = aligned(sizeof header), s = 0;
  for_each_section(content, [&](const auto& array) {
    header.sections[s++] = {end, array.size()};
    end = aligned(end + array.size_bytes());
  });
  header.file_bytes = end;
  std::vector<std::byte> bytes(end);
  s = 0;
  for_each_section(content, [&](const auto& array) {
    const Section& section = header.sections[s++];
    if (!array.empty())
      std::memcpy(bytes.data() + section.offset, array.data(), array.size_bytes());
  });
  header.checksums = {first_checksum(header, bytes), second_checksum(bytes)};
  std::memcpy(bytes.data(), &header, sizeof header);
  return bytes;
}

BakedContent view_baked(std::span<const std::byte> bytes, uint64_t key, const RunBoth& run_both) {
  const Header header = read_header(bytes, key);
  require(reinterpret_cast<uintptr_t>(bytes.data()) % alignof(double) == 0, "not aligned");
  BakedContent content;
  size_t s = 0;
  for_each_section(content, [&]<class T>(std::span<const T>& array) {
    array = view_section<T>(bytes, header.sections[s++]);
  });
  TriangleMesh& mesh = content.shape.mesh;
  mesh.lower = header.lower;
  mesh.upper = header.upper;
  mesh.closed = header.closed != 0;
  HashGrid& grid = content.shape.grid;
  grid.lower_O = header.grid_lower;
  grid.cell = header.cell;
  grid.cells_per_metre = 1 / header.cell;
  const MeshShape& shape = content.shape;
  run_both(
      [&] {
        require(header.checksums[0] == first_checksum(header, bytes), "damaged");
        check_mesh(shape.mesh);
        check_eye(content);
      },
      [&] {
        require(header.checksums[1] == second_checksum(bytes), "damaged");
        check_tree(shape.tree, shape.mesh.triangles.size());
        check_grid(shape.grid, shape.mesh.triangles.size(), shape.tree.nodes.size());
        check_patches(shape.patches, shape.mesh);
      });
  return content;
}

}  // namespace haptic
