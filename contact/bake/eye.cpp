// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/eye.h"

#include <OpenMesh/Core/Mesh/Traits.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>

namespace haptic {
namespace {

struct DoubleTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using EyeMesh = OpenMesh::TriMesh_ArrayKernelT<DoubleTraits>;

EyeMesh copy_in(const TriangleMesh& mesh) {
  EyeMesh eye;
  for (const Vec3& v : mesh.vertices) eye.add_vertex({v.x, v.y, v.z});
  for (const auto& [a, b, c] : mesh.triangles) {
    eye.add_face(EyeMesh::VertexHandle(static_cast<int>(a)),
                 EyeMesh::VertexHandle(static_cast<int>(b)),
                 EyeMesh::VertexHandle(static_cast<int>(c)));
  }
  return eye;
}

void decimate(EyeMesh& eye, size_t max_triangles) {
  OpenMesh::Decimater::DecimaterT<EyeMesh> decimater(eye);
  OpenMesh::Decimater::ModQuadricT<EyeMesh>::Handle quadric;
  decimater.add(quadric);
  decimater.module(quadric).unset_max_err();
  decimater.initialize();
  decimater.decimate_to_faces(0, max_triangles);
  eye.garbage_collection();
}

}  // namespace

MeshData build_eye_mesh(const TriangleMesh& mesh, size_t max_triangles) {
  std::vector<Vec3> vertices(mesh.vertices.begin(), mesh.vertices.end());
  std::vector<Triangle> triangles(mesh.triangles.begin(), mesh.triangles.end());
  if (triangles.size() > max_triangles) {
    EyeMesh eye = copy_in(mesh);
    decimate(eye, max_triangles);
    vertices.clear();
    triangles.clear();
    for (const auto v : eye.vertices()) {
      const auto& p = eye.point(v);
      vertices.push_back({p[0], p[1], p[2]});
    }
    for (const auto f : eye.faces()) {
      Triangle triangle{};
      size_t i = 0;
      for (const auto v : eye.fv_range(f)) triangle[i++] = static_cast<uint32_t>(v.idx());
      triangles.push_back(triangle);
    }
  }
  return build_mesh(std::move(vertices), std::move(triangles));
}

}  // namespace haptic
