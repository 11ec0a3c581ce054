// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/eye_files.h"

#include <stdexcept>

#include "contact/bake/piece_files.h"
#include "contact/shape/mesh/mesh_topology.h"
#include "contact/shape/mesh/primitives.h"
#include "proto/ipc/eye_file.h"
#include "proto/ipc/segment.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

constexpr size_t kMostPoints = size_t{1} << 16;  // more are a solid on any screen
constexpr size_t kMostPieceTriangles = 40'000;   // twice as many as a mesh is drawn with
constexpr uint32_t kSphereSubdivisions = 3;      // 1280 triangles: round at the size of a tool

/// A mesh for display.
struct EyeArrays {
  std::span<const Vec3> vertices, normals;
  std::span<const Triangle> triangles;
};

EyeColour colour_of(uint32_t rgb) {
  const auto share = [rgb](int shift) { return static_cast<float>((rgb >> shift) & 0xff) / 255; };
  return {share(16), share(8), share(0), 1};
}

std::vector<EyePoint> as_floats(std::span<const Vec3> points) {
  std::vector<EyePoint> floats;
  floats.reserve(points.size());
  for (const Vec3& p : points) {
    floats.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
  }
  return floats;
}

/// Every n-th point: they are in Morton order, so the rest is as even as all.
std::vector<EyePoint> points_of(const Pointshell& shell) {
  const size_t step = shell.x.size() / kMostPoints + 1;
  std::vector<EyePoint> points;
  points.reserve(shell.x.size() / step + 1);
  for (size_t i = 0; i < shell.x.size(); i += step) {
    points.push_back({shell.x[i], shell.y[i], shell.z[i]});
  }
  return points;
}

std::vector<std::byte> write(uint32_t object, const ShapeConfig& shape, const EyeArrays& mesh,
                             std::span<const EyePoint> points) {
  const std::vector<EyePoint> vertices = as_floats(mesh.vertices);
  const std::vector<EyePoint> normals = as_floats(mesh.normals);
  return write_eye({.object = object,
                    .name = std::string(view(shape.name)),
                    .colour = colour_of(shape.colour),
                    .vertices = vertices,
                    .normals = normals,
                    .triangles = mesh.triangles,
                    .points = points});
}

EyeArrays arrays_of(const BakedShape& shape) {
  return {shape.eye_vertices, shape.eye_normals, shape.eye_triangles};
}

std::vector<std::byte> make_sphere(const SessionConfig& config) {
  const bool is_sphere = row_of(config.renderer).moves == Moves::kSphere && config.proxy_radius > 0;
  Soup soup = make_icosphere(is_sphere ? config.proxy_radius : kPointRadius, kSphereSubdivisions);
  const MeshData mesh = build_mesh(std::move(soup.vertices), std::move(soup.triangles));
  return write(eye_of_tool(config.hand), config.tool,
               {mesh.vertices, mesh.vertex_normals, mesh.triangles}, {});
}

uint32_t level_to_draw(const PieceTree& tree) {
  const std::vector<PieceLevel> levels = levels_of(tree);
  uint32_t level = 0;
  while (level + 1 < levels.size() && levels[level].triangles > kMostPieceTriangles) ++level;
  return level;
}

/// Adds a hull: its vertices, the sums of the normals around them, and its faces as fans.
void add_hull(const Hull& hull, std::vector<Vec3>& vertices, std::vector<Vec3>& normals,
              std::vector<Triangle>& triangles) {
  const auto first = static_cast<uint32_t>(vertices.size());
  vertices.insert(vertices.end(), hull.vertices.begin(), hull.vertices.end());
  normals.resize(vertices.size());
  for (const HullFace& face : hull.faces) {
    const auto at = [&](uint32_t k) { return first + hull.edges[face.first_edge + k].from; };
    for (uint32_t k = 0; k < face.n_edges; ++k) normals[at(k)] += face.normal;
    for (uint32_t k = 2; k < face.n_edges; ++k) triangles.push_back({at(0), at(k - 1), at(k)});
  }
}

}  // namespace

std::vector<std::byte> make_piece_eye(uint32_t object, const ShapeConfig& shape,
                                      const PieceTree& tree) {
  std::vector<Vec3> vertices, normals;
  std::vector<Triangle> triangles;
  for (const uint32_t i : pieces_at(tree, level_to_draw(tree))) {
    add_hull(tree.hull(tree.pieces[i]), vertices, normals, triangles);
  }
  // the two sides of a flat piece cancel: any unit vector will do, the page shades by the faces
  for (Vec3& n : normals) n = norm(n) > 0.1 ? normalized(n) : Vec3{0, 0, 1};
  return write(object, shape, {vertices, normals, triangles}, {});
}

std::vector<std::byte> make_eye(const SessionConfig& config, const BakedSession& baked,
                                uint32_t object) {
  if (!is_eye_of_tool(object)) {
    return write(object, config.objects.at(object), arrays_of(baked.objects.at(object)), {});
  }
  if (!baked.tool) return make_sphere(config);
  const std::vector<EyePoint> points =
      baked.shell ? points_of(baked.shell->content.shell) : std::vector<EyePoint>{};
  return write(eye_of_tool(config.hand), config.tool, arrays_of(*baked.tool), points);
}

std::vector<SealedEye> make_eye_files(const SessionConfig& config, const BakedSession& baked,
                                      const std::function<void(const std::string&)>& tell) {
  std::vector<SealedEye> eyes;
  const auto add = [&](SegmentId id, const ShapeConfig& shape, const auto& make) {
    const std::string name(view(shape.name));
    try {
      eyes.push_back({id, name, make_sealed_file("haptic-eye", make())});
    } catch (const std::runtime_error& error) {
      tell("'" + shown(name) + "' cannot be drawn: " + error.what());
    }
  };
  const auto add_both = [&](uint32_t object, const ShapeConfig& shape, const BakedPieces* pieces) {
    add(eye_id(object), shape, [&] { return make_eye(config, baked, object); });
    if (pieces == nullptr || pieces->tree.pieces.empty()) return;
    add(pieces_id(object), shape, [&] { return make_piece_eye(object, shape, pieces->tree); });
  };
  add_both(eye_of_tool(config.hand), config.tool,
           baked.tool_pieces ? &*baked.tool_pieces : nullptr);
  // the contact of the first hand draws the objects for all
  if (config.hand != kFirstHand) return eyes;
  for (uint32_t i = 0; i < config.n_objects - config.n_tools; ++i) {
    add_both(i, config.objects[i], i < baked.pieces.size() ? &baked.pieces[i] : nullptr);
  }
  return eyes;
}

}  // namespace haptic
