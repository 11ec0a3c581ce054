// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/convex/hull.h"

#include <cmath>
#include <cstddef>

#include "proto/math/assert.h"

namespace haptic {

uint32_t support_vertex(const Hull& hull, const Vec3& direction, uint32_t start) {
  HAPTIC_ASSERT(start < hull.vertices.size());
  uint32_t best = start;
  double reach = dot(direction, hull.vertices[best]);
  // each move gains, so no vertex comes twice
  for (bool moved = true; moved;) {
    moved = false;
    for_edges_around(hull, best, [&](uint32_t edge) {
      const uint32_t to = end_vertex(hull, edge);
      const double there = dot(direction, hull.vertices[to]);
      if (there > reach) reach = there, best = to, moved = true;
    });
  }
  return best;
}

namespace {

const char* indices_defect(const Hull& hull) {
  const size_t n_vertices = hull.vertices.size(), n_edges = hull.edges.size();
  if (hull.edge_from.size() != n_vertices) return "there is not one outgoing edge for each vertex";
  for (const HullEdge& e : hull.edges) {
    if (e.from >= n_vertices || e.twin >= n_edges || e.next >= n_edges ||
        e.face >= hull.faces.size()) {
      return "an index of an edge is out of range";
    }
  }
  for (const HullFace& face : hull.faces) {
    if (face.n_edges < 3) return "a face has less than three edges";
    if (face.first_edge > n_edges || face.n_edges > n_edges - face.first_edge) {
      return "the edges of a face are out of range";
    }
  }
  for (const uint32_t edge : hull.edge_from) {
    if (edge >= n_edges) return "the outgoing edge of a vertex is out of range";
  }
  return nullptr;
}

const char* cycles_defect(const Hull& hull) {
  for (uint32_t i = 0; i < hull.edges.size(); ++i) {
    const HullEdge &e = hull.edges[i], &twin = hull.edges[e.twin];
    if (e.twin == i || twin.twin != i) return "twins do not name each other";
    if (twin.from != hull.edges[e.next].from) return "an edge does not end where its twin begins";
    if (twin.face == e.face) return "a face is its own neighbour";
  }
  size_t n_edges = 0;
  for (uint32_t f = 0; f < hull.faces.size(); ++f) {
    const HullFace& face = hull.faces[f];
    n_edges += face.n_edges;
    for (uint32_t k = 0; k < face.n_edges; ++k) {
      const HullEdge& e = hull.edges[face.first_edge + k];
      if (e.face != f) return "an edge belongs to another face";
      if (e.next != face.first_edge + (k + 1) % face.n_edges) return "a face is not a cycle";
    }
  }
  if (n_edges != hull.edges.size()) return "an edge belongs to no face";
  if (hull.vertices.size() + hull.faces.size() != hull.edges.size() / 2 + 2) {
    return "V - E + F is not 2";
  }
  // one fan around each vertex: with Euler's formula the surface is a sphere
  size_t around = 0;
  for (uint32_t v = 0; v < hull.vertices.size(); ++v) {
    uint32_t edge = hull.edge_from[v];
    do {
      if (hull.edges[edge].from != v) return "the outgoing edge of a vertex leaves another";
      edge = next_around(hull, edge);
      if (++around > hull.edges.size()) return "the edges around a vertex are no cycle";
    } while (edge != hull.edge_from[v]);
  }
  return around == hull.edges.size() ? nullptr : "two fans meet at a vertex";
}

}  // namespace

const char* hull_links_defect(const Hull& hull) {
  if (const char* defect = indices_defect(hull)) return defect;
  return cycles_defect(hull);
}

const char* hull_defect(const Hull& hull, double tolerance) {
  if (const char* defect = hull_links_defect(hull)) return defect;
  for (const HullFace& face : hull.faces) {
    if (!(std::fabs(norm_squared(face.normal) - 1) < 1e-9)) return "a normal is not a unit vector";
    for (const Vec3& p : hull.vertices) {
      if (!(dot(face.normal, p) - face.offset <= tolerance)) return "a vertex is beyond a face";
    }
    for (uint32_t k = 0; k < face.n_edges; ++k) {
      const Vec3& p = hull.vertices[hull.edges[face.first_edge + k].from];
      if (!(std::fabs(dot(face.normal, p) - face.offset) <= tolerance)) {
        return "a vertex of a face is not in its plane";
      }
    }
  }
  return nullptr;
}

}  // namespace haptic
