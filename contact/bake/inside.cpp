// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/inside.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>

#include "contact/bake/soup/report.h"

namespace haptic {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;

namespace {

SurfaceMesh copy_mesh(const TriangleMesh& mesh) {
  if (!mesh.closed) throw MeshError("inside test: the mesh is not closed; give a closed mesh");
  SurfaceMesh copy;
  for (const Vec3& v : mesh.vertices) copy.add_vertex({v.x, v.y, v.z});
  for (const auto& [a, b, c] : mesh.triangles) {
    using Vertex = SurfaceMesh::Vertex_index;
    if (copy.add_face(Vertex(a), Vertex(b), Vertex(c)) == SurfaceMesh::null_face()) {
      throw MeshError("inside test: the mesh is not a manifold; bake it first");
    }
  }
  return copy;
}

}  // namespace

struct InsideOracle::Tree {
  explicit Tree(const TriangleMesh& mesh) : surface(copy_mesh(mesh)), side(surface) {}
  SurfaceMesh surface;
  CGAL::Side_of_triangle_mesh<SurfaceMesh, Kernel> side;
};

InsideOracle::InsideOracle(const TriangleMesh& mesh) : tree_(std::make_unique<Tree>(mesh)) {}
InsideOracle::~InsideOracle() = default;

bool InsideOracle::inside(const Vec3& p_O) const {
  return tree_->side({p_O.x, p_O.y, p_O.z}) == CGAL::ON_BOUNDED_SIDE;
}

}  // namespace haptic
