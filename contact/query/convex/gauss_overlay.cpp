// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/convex/gauss_overlay.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"

namespace haptic {
namespace {

// sine of the angle below which directions are parallel: above what rounding makes of a face whose
// edges are a hundredth of the hull, below what would show in a depth (5e-13 m at 50 mm)
constexpr double kParallel = 1e-11;

/// Calls use(half-edge, way to the neighbour) for each edge that leaves a vertex.
template <class Use>
void for_neighbours(const Hull& hull, uint32_t vertex, const Use& use) {
  for_edges_around(hull, vertex, [&](uint32_t edge) {
    use(edge, hull.vertices[end_vertex(hull, edge)] - hull.vertices[vertex]);
  });
}

/// A place on a great circle: x along the start, y ≥ 0 along its tangent; of any length.
struct Turn {
  double x, y;

  /// By a smaller angle, of 0 to 180 degrees.
  bool before(const Turn& b) const {
    const double sine = x * b.y - y * b.x;
    return sine > 0 || (sine == 0 && x > b.x);
  }
};

bool is_parallel(const Vec3& unit, const Vec3& other_unit) {
  return norm_squared(unit - other_unit) <= kParallel * kParallel;
}

/// Returns true if an extreme vertex's neighbour is as far along a direction.
bool is_level(double drop, double length2) {
  return drop <= 0 || drop * drop <= kParallel * kParallel * length2;
}

}  // namespace

Vec3 GaussOverlay::opposite(int side, uint32_t vertex) const {
  return side == 0 ? pair_.vertex_b(vertex) : R_BA_ * (pair_.a.vertices[vertex] - pair_.p_AB);
}

double GaussOverlay::support(const Vec3& normal_A, uint32_t& vertex_a, uint32_t& vertex_b) const {
  vertex_a = support_vertex(pair_.a, normal_A, vertex_a);
  vertex_b = support_vertex(pair_.b, across(0, normal_A), vertex_b);
  return dot(normal_A, pair_.vertex_a(vertex_a) - pair_.vertex_b(vertex_b));
}

bool GaussOverlay::at(const HullFeature& a, const HullFeature& b, OverlayVertex& out) const {
  out.feature = {a, b};
  for (const int side : {0, 1}) {
    const HullFeature& feature = side == 0 ? a : b;
    HullFeature& other = out.feature[static_cast<size_t>(1 - side)];
    if (feature.kind != HullPart::kFace) continue;
    const HullFace& face = hull(side).faces[feature.index];
    const Vec3 outward = across(side, face.normal);
    other = {HullPart::kVertex,
             support_vertex(hull(1 - side), outward, corner_of(hull(1 - side), other))};
    out.normal[static_cast<size_t>(side)] = face.normal;
    out.normal[static_cast<size_t>(1 - side)] = outward;
    out.depth = face.offset - dot(face.normal, opposite(side, other.index));
    return true;
  }
  if (a.kind != HullPart::kEdge || b.kind != HullPart::kEdge) return false;
  const Vec3 way_a = pair_.a.vertices[end_vertex(pair_.a, a.index)] -
                     pair_.a.vertices[pair_.a.edges[a.index].from];
  const Vec3 way_b = pair_.R_AB * (pair_.b.vertices[end_vertex(pair_.b, b.index)] -
                                   pair_.b.vertices[pair_.b.edges[b.index].from]);
  Vec3 normal = cross(way_a, way_b);
  const double sine2 = norm_squared(normal), scale2 = norm_squared(way_a) * norm_squared(way_b);
  if (!(sine2 > 1e-12 * scale2)) return false;  // too nearly parallel for a direction of their own
  const HullEdge &edge_a = pair_.a.edges[a.index], &edge_b = pair_.b.edges[b.index];
  if (dot(normal, pair_.a.faces[edge_a.face].normal +
                      pair_.a.faces[pair_.a.edges[edge_a.twin].face].normal) < 0) {
    normal = -normal;
  }
  normal *= 1 / std::sqrt(sine2);
  out.normal = {normal, across(0, normal)};
  // between the normals of both faces of each edge: beyond no other vertex of these faces
  for (const int side : {0, 1}) {
    const Hull& h = hull(side);
    const HullEdge& edge = side == 0 ? edge_a : edge_b;
    const Vec3& m = out.normal[static_cast<size_t>(side)];
    const double reach = dot(m, h.vertices[edge.from]);
    const uint32_t left = end_vertex(h, edge.next), right = end_vertex(h, h.edges[edge.twin].next);
    if (dot(m, h.vertices[left]) > reach || dot(m, h.vertices[right]) > reach) return false;
  }
  out.depth = dot(normal, pair_.vertex_a(edge_a.from) - pair_.vertex_b(edge_b.from));
  return true;
}

void GaussOverlay::join_parallel(OverlayVertex& at, int side) const {
  HullFeature& feature = at.feature[static_cast<size_t>(side)];
  const Vec3& m = at.normal[static_cast<size_t>(side)];
  const Hull& h = hull(side);
  if (feature.kind == HullPart::kVertex) {
    uint32_t level = kNoTriangle;
    for_neighbours(h, feature.index, [&](uint32_t edge, const Vec3& way) {
      if (level == kNoTriangle && is_level(-dot(m, way), norm_squared(way))) level = edge;
    });
    if (level == kNoTriangle) return;
    feature = {HullPart::kEdge, level};
  }
  if (feature.kind == HullPart::kEdge) {
    const HullEdge& edge = h.edges[feature.index];
    for (const uint32_t face : {edge.face, h.edges[edge.twin].face}) {
      if (is_parallel(m, h.faces[face].normal)) feature = {HullPart::kFace, face};
    }
  }
}

OverlayArc GaussOverlay::arc_at(const OverlayVertex& at, int side, uint32_t edge,
                                uint32_t vertex) const {
  const Hull& h = hull(side);
  const Vec3& from = h.vertices[h.edges[edge].from];
  OverlayArc arc{side, edge, vertex, {}, 0, 0};
  arc.tangent = cross(h.vertices[end_vertex(h, edge)] - from, at.normal[static_cast<size_t>(side)]);
  arc.length2 = norm_squared(arc.tangent);
  // of the other side's level vertices the one farthest along the arc
  const HullFeature& other = at.feature[static_cast<size_t>(1 - side)];
  if (other.kind != HullPart::kVertex) {
    const Hull& o = hull(1 - side);
    const Vec3 tangent = across(side, arc.tangent);
    const auto take = [&](uint32_t v) {
      if (dot(tangent, o.vertices[v]) > dot(tangent, o.vertices[arc.vertex])) arc.vertex = v;
    };
    if (other.kind == HullPart::kEdge) {
      take(end_vertex(o, other.index));
    } else {
      const HullFace& face = o.faces[other.index];
      for (uint32_t k = 0; k < face.n_edges; ++k) take(o.edges[face.first_edge + k].from);
    }
  }
  arc.extent = dot(arc.tangent, from - opposite(side, arc.vertex));
  return arc;
}

OverlayVertex GaussOverlay::end_of(const OverlayVertex& from, const OverlayArc& arc) const {
  const auto x = static_cast<size_t>(arc.side), y = 1 - x;
  const Hull &h = hull(arc.side), &o = hull(1 - arc.side);
  const Vec3 &m = from.normal[x], &m_other = from.normal[y];
  const Vec3 tangent = across(arc.side, arc.tangent);
  const uint32_t face = h.edges[h.edges[arc.edge].twin].face;
  const Vec3& end = h.faces[face].normal;
  // the arc ends at the face, or where a neighbour of the vertex becomes the support
  Turn first{dot(end, m) * arc.length2, std::max(dot(end, arc.tangent), 0.0)};
  uint32_t crossed = kNoTriangle;
  for_neighbours(o, arc.vertex, [&](uint32_t edge, const Vec3& way) {
    const double drop = -dot(m_other, way), change = dot(tangent, way);
    const Turn here{change, std::max(drop, 0.0)};
    if (!here.before(first)) return;
    // parallel to the edge of the arc: level along all of it
    const double least2 = kParallel * kParallel * norm_squared(way);
    if (drop * drop <= least2 && change * change <= least2 * arc.length2) return;
    first = here;
    crossed = edge;
  });
  OverlayVertex out;
  const double scale = 1 / std::sqrt(first.x * first.x + first.y * first.y * arc.length2);
  out.depth = scale * (first.x * from.depth + first.y * arc.extent);
  if (crossed == kNoTriangle) {
    out.feature[x] = {HullPart::kFace, face};
    out.feature[y] = {HullPart::kVertex, arc.vertex};
    out.normal[x] = end;
  } else {
    out.feature[x] = {HullPart::kEdge, arc.edge};
    out.feature[y] = {HullPart::kEdge, crossed};
    out.normal[x] = scale * (first.x * m + first.y * arc.tangent);
  }
  out.normal[y] = across(arc.side, out.normal[x]);
  return out;
}

OverlayVertex GaussOverlay::near(const Vec3& normal_A, uint32_t vertex_a, uint32_t vertex_b) const {
  // downhill within the region of the two vertices, to its first arc
  OverlayVertex start;
  start.normal = {normal_A, across(0, normal_A)};
  const Vec3 corner = pair_.vertex_a(vertex_a) - pair_.vertex_b(vertex_b);
  start.depth = dot(normal_A, corner);
  Vec3 downhill = start.depth * normal_A - corner;
  if (!(norm_squared(downhill) > kParallel * kParallel * norm_squared(corner))) {
    downhill = any_perpendicular(normal_A);  // straight above the corner: any way is downhill
  }
  const std::array<Vec3, 2> tangents{downhill, across(0, downhill)};
  Turn first{-1, 0};
  int side = 0;
  uint32_t crossed = hull(0).edge_from[vertex_a];
  for (const int k : {0, 1}) {
    const auto i = static_cast<size_t>(k);
    for_neighbours(hull(k), k == 0 ? vertex_a : vertex_b, [&](uint32_t edge, const Vec3& way) {
      const Turn here{dot(tangents[i], way), std::max(-dot(start.normal[i], way), 0.0)};
      if (here.before(first)) first = here, side = k, crossed = edge;
    });
  }
  const auto x = static_cast<size_t>(side);
  OverlayVertex on_arc = start;
  on_arc.normal[0] = normalized(first.x * start.normal[0] + first.y * downhill);
  on_arc.normal[1] = across(0, on_arc.normal[0]);
  on_arc.depth = dot(on_arc.normal[0], corner);
  on_arc.feature[x] = {HullPart::kEdge, crossed};
  on_arc.feature[1 - x] = {HullPart::kVertex, side == 0 ? vertex_b : vertex_a};
  // then along it, downhill
  OverlayArc arc = arc_at(on_arc, side, crossed, on_arc.feature[1 - x].index);
  if (arc.extent > 0) {
    arc = arc_at(on_arc, side, hull(side).edges[crossed].twin, arc.vertex);
  }
  return end_of(on_arc, arc);
}

}  // namespace haptic
