// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/eye_files.h"

#include <stdexcept>

#include "contact/shape/mesh/mesh_topology.h"
#include "contact/shape/mesh/primitives.h"
#include "proto/ipc/eye_file.h"
#include "proto/ipc/segment.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

constexpr size_t kMostPoints = size_t{1} << 16;  // more are a solid on any screen
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
  return write(kEyeOfTool, config.tool, {mesh.vertices, mesh.vertex_normals, mesh.triangles}, {});
}

}  // namespace

std::vector<std::byte> make_eye(const SessionConfig& config, const BakedSession& baked,
                                uint32_t object) {
  if (object != kEyeOfTool) {
    return write(object, config.objects.at(object), arrays_of(baked.objects.at(object)), {});
  }
  if (!baked.tool) return make_sphere(config);
  const std::vector<EyePoint> points =
      baked.shell ? points_of(baked.shell->content.shell) : std::vector<EyePoint>{};
  return write(kEyeOfTool, config.tool, arrays_of(*baked.tool), points);
}

std::vector<SealedEye> make_eye_files(const SessionConfig& config, const BakedSession& baked,
                                      const std::function<void(const std::string&)>& tell) {
  std::vector<SealedEye> eyes;
  const auto add = [&](uint32_t object, const ShapeConfig& shape) {
    const std::string name(view(shape.name));
    try {
      eyes.push_back(
          {eye_id(object), name, make_sealed_file("haptic-eye", make_eye(config, baked, object))});
    } catch (const std::runtime_error& error) {
      tell("'" + shown(name) + "' cannot be drawn: " + error.what());
    }
  };
  add(kEyeOfTool, config.tool);
  for (uint32_t i = 0; i < config.n_objects; ++i) add(i, config.objects[i]);
  return eyes;
}

}  // namespace haptic
