// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/convex/piece_surgery.h"

#include <OpenMesh/Core/Mesh/Traits.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <queue>
#include <set>
#include <tuple>
#include <utility>

#include "contact/bake/convex/cut_polygon.h"
#include "contact/bake/convex/half_spaces.h"
#include "contact/bake/convex/hull_of_points.h"
#include "contact/bake/convex/quadric.h"
#include "contact/bake/convex/triangle_boxes.h"
#include "contact/shape/mesh/distinct.h"
#include "proto/os/message.h"

namespace haptic {
namespace {

constexpr double kFilter = 0.005;  // weight of the middle of the neighbours
constexpr double kOfLength = 0.2;  // of an edge, in its cost
constexpr double kMostOff =
    0.03;                         // cost of a collapse, of the mesh's size: beyond is another shape
constexpr double kTurn = 0.2;     // least cosine between a triangle before and after
constexpr double kSliver = 1e-3;  // least height of a new triangle, of its longest side
constexpr double kEntered = 0.25;         // depth of other surface in a merged hull, of a mean edge
constexpr size_t kMostTriangles = 4096;   // of a merged piece, as in decompose_surface
constexpr size_t kMostHalfSpaces = 4096;  // with more, only the ends of the edge are tried

struct DoubleTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
  VertexAttributes(OpenMesh::Attributes::Status);
  EdgeAttributes(OpenMesh::Attributes::Status);
  FaceAttributes(OpenMesh::Attributes::Status);
};
using Mesh = OpenMesh::TriMesh_ArrayKernelT<DoubleTraits>;
using Vertex = OpenMesh::VertexHandle;
using Face = OpenMesh::FaceHandle;
using Edge = OpenMesh::EdgeHandle;
using Halfedge = OpenMesh::HalfedgeHandle;

uint32_t number(const OpenMesh::BaseHandle& handle) {
  return static_cast<uint32_t>(handle.idx());
}

/// The facets and corners that a piece keeps after a collapse.
struct Rest {
  uint32_t piece;
  std::vector<uint32_t> planes;            // faces without the vertex that moves
  std::vector<std::pair<Vec3, Vec3>> fan;  // of each other face the side opposite to it
  std::vector<Vec3> points;                // its vertices but that which moves
};

/// A collapse that the surface allows, before its vertex has a place.
struct Collapse {
  Halfedge along;                // from the vertex that goes to the one that stays
  std::vector<Face> moving;      // faces that get another corner
  std::vector<uint32_t> pieces;  // that have a face around the edge
  std::vector<Rest> rests;       // of those of the pieces that keep a face
};

}  // namespace

struct PieceSurgery::State {
  struct Offer {
    double cost;
    uint32_t edge, stamp;
    bool operator>(const Offer& b) const { return std::tie(cost, edge) > std::tie(b.cost, b.edge); }
  };

  Mesh mesh;
  bool is_sound = true;
  double margin = 0, most_off = 0;  // [m]
  TriangleMesh original;
  TriangleBoxes boxes;
  std::vector<uint32_t> leaf_of;               // of each original triangle: its first piece
  std::vector<uint32_t> joined_to;             // of each piece: another one, or itself
  std::vector<std::vector<Face>> faces;        // of each piece that is left
  std::vector<std::vector<uint32_t>> members;  // of the same: pieces of the level before
  std::vector<bool> has_moved;
  std::vector<uint32_t> piece_of;  // of each face
  std::vector<Plane> planes;       // of each face
  std::vector<Quadric> quadrics;   // of each vertex
  std::vector<uint32_t> stamps;    // of each edge: offers before it are void
  std::priority_queue<Offer, std::vector<Offer>, std::greater<>> offers;
  size_t n_pieces = 0;

  Vec3 at(Vertex v) const {
    const Mesh::Point& p = mesh.point(v);
    return {p[0], p[1], p[2]};
  }
  std::array<Vertex, 3> corners(Face f) const {
    const Halfedge h = mesh.halfedge_handle(f);
    return {mesh.from_vertex_handle(h), mesh.to_vertex_handle(h),
            mesh.to_vertex_handle(mesh.next_halfedge_handle(h))};
  }
  bool has_corner(Face f, Vertex v) const {
    const auto c = corners(f);
    return std::find(c.begin(), c.end(), v) != c.end();
  }
  uint32_t piece(Face f) const { return f.is_valid() ? piece_of[number(f)] : ~0u; }
  uint32_t root(uint32_t p) {
    while (joined_to[p] != p) p = joined_to[p] = joined_to[joined_to[p]];
    return p;
  }

  void read(const TriangleMesh& from, const SurfacePieces& pieces);
  Vec3 best_place(Vertex goes, Vertex stays, Quadric& quadric) const;
  void offer(Edge e);
  void offer_around(Vertex v);

  bool is_pinched(const Collapse& collapse) const;
  bool is_allowed(Halfedge h);
  std::optional<Collapse> collapse_along(Halfedge h);
  Rest rest_of(uint32_t p, const Collapse& collapse) const;
  std::vector<Plane> half_spaces(const Collapse& collapse) const;
  bool keeps_convex(const Rest& rest, const Vec3& p) const;
  bool keeps_normals(const Collapse& collapse, const Vec3& p) const;
  bool fits(const Collapse& collapse, const Vec3& p) const;
  std::optional<Vec3> place_of(const Collapse& collapse) const;
  void perform(const Collapse& collapse, const Vec3& p);
  void give_away(uint32_t p, const std::vector<std::pair<uint32_t, Vec3>>& beside, const Vec3& n);
  bool try_edge(Edge e);

  std::vector<Vec3> points_of(const std::vector<Face>& of) const;
  bool is_convex(const std::vector<Face>& of, const std::vector<Vec3>& points) const;
  bool is_disc(uint32_t a, uint32_t b) const;
  bool is_entered(uint32_t a, uint32_t b, const std::vector<Vec3>& points);
  bool may_merge(uint32_t a, uint32_t b);
  void merge(uint32_t a, uint32_t b);
  void merge_over(Edge e);
  void merge_around(Vertex v);
};

void PieceSurgery::State::read(const TriangleMesh& from, const SurfacePieces& pieces) {
  original = from;
  boxes = build_triangle_boxes(from);
  const double size = longest_of(from.upper - from.lower);
  margin = kPieceTolerance * size;
  most_off = kMostOff * size;
  for (const Vec3& v : from.vertices) mesh.add_vertex({v.x, v.y, v.z});
  quadrics.resize(from.vertices.size());
  for (uint32_t t = 0; t < from.triangles.size(); ++t) {
    const auto& [a, b, c] = from.triangles[t];
    const auto handle = [](uint32_t v) { return Vertex(static_cast<int>(v)); };
    // a fan that two solids share cannot be told apart by half-edges
    if (!mesh.add_face(handle(a), handle(b), handle(c)).is_valid()) is_sound = false;
    const Vec3 &p = from.vertices[a], &q = from.vertices[b], &r = from.vertices[c];
    planes.push_back(plane_through(p, q, r));
    for (const uint32_t v : {a, b, c}) quadrics[v].add(planes.back(), norm(cross(q - p, r - p)));
  }
  leaf_of = piece_of = pieces.piece_of;
  n_pieces = pieces.triangles.size();
  joined_to.resize(n_pieces);
  std::iota(joined_to.begin(), joined_to.end(), 0);
  has_moved.assign(n_pieces, false);
  for (uint32_t p = 0; p < n_pieces; ++p) {
    members.push_back({p});
    faces.emplace_back();
    for (const uint32_t t : pieces.triangles[p]) faces[p].emplace_back(static_cast<int>(t));
  }
  stamps.assign(mesh.n_edges(), 0);
}

Vec3 PieceSurgery::State::best_place(Vertex goes, Vertex stays, Quadric& quadric) const {
  Vec3 middle;
  double n = 0;
  for (const Vertex end : {goes, stays}) {
    for (const Vertex v : mesh.vv_range(end)) {
      if (v != goes && v != stays) middle += at(v), n += 1;
    }
  }
  quadric = quadrics[number(goes)];
  quadric.add(quadrics[number(stays)]);
  // planes that hardly differ meet far away: then the middle of the neighbours counts for more
  const Vec3 between = 0.5 * (at(goes) + at(stays));
  const double far = norm(at(goes) - at(stays));
  for (double weight = kFilter; weight < 1; weight *= 10) {
    const Vec3 place = filtered_minimum(quadric, middle / n, weight);
    if (norm(place - between) <= far) return place;
  }
  return between;
}

void PieceSurgery::State::offer(Edge e) {
  const Halfedge h = mesh.halfedge_handle(e, 0);
  const Vertex goes = mesh.from_vertex_handle(h), stays = mesh.to_vertex_handle(h);
  Quadric quadric;
  const Vec3 place = best_place(goes, stays, quadric);
  const double cost = quadric.distance(place) + kOfLength * norm(at(goes) - at(stays));
  offers.push({cost, number(e), ++stamps[number(e)]});
}

void PieceSurgery::State::offer_around(Vertex v) {
  for (const auto h : mesh.voh_range(v)) {
    offer(mesh.edge_handle(h));
    if (!mesh.is_boundary(h)) offer(mesh.edge_handle(mesh.next_halfedge_handle(h)));
  }
}

/// Whether the surface stays a manifold with the same borders.
bool PieceSurgery::State::is_allowed(Halfedge h) {
  const Vertex goes = mesh.from_vertex_handle(h), stays = mesh.to_vertex_handle(h);
  if (mesh.is_boundary(goes) || !mesh.is_collapse_ok(h)) return false;
  // two triangles with the same corners would be left
  for (const Halfedge side : {h, mesh.opposite_halfedge_handle(h)}) {
    const Vertex top = mesh.to_vertex_handle(mesh.next_halfedge_handle(side));
    if (mesh.valence(top) <= 3 && !mesh.is_boundary(top)) return false;
  }
  return mesh.valence(goes) + mesh.valence(stays) > 6;
}

/// Whether a piece would be only held together by the vertex: both ends of the edge are its own,
/// but not the way between them.
bool PieceSurgery::State::is_pinched(const Collapse& collapse) const {
  const Vertex goes = mesh.from_vertex_handle(collapse.along);
  const Vertex stays = mesh.to_vertex_handle(collapse.along);
  const uint32_t left = piece(mesh.face_handle(collapse.along));
  const uint32_t right = piece(mesh.face_handle(mesh.opposite_halfedge_handle(collapse.along)));
  const auto touches = [&](Vertex v, uint32_t p) {
    const auto range = mesh.vf_range(v);
    return std::any_of(range.begin(), range.end(), [&](Face f) { return piece(f) == p; });
  };
  const auto is_inside = [&](Vertex v, uint32_t p) {
    const auto range = mesh.vf_range(v);
    return !mesh.is_boundary(v) &&
           std::all_of(range.begin(), range.end(), [&](Face f) { return piece(f) == p; });
  };
  return std::any_of(collapse.pieces.begin(), collapse.pieces.end(), [&](uint32_t p) {
    if (p != left && p != right) return touches(goes, p) && touches(stays, p);
    return left == right && !is_inside(goes, p) && !is_inside(stays, p);
  });
}

Rest PieceSurgery::State::rest_of(uint32_t p, const Collapse& collapse) const {
  const Vertex goes = mesh.from_vertex_handle(collapse.along);
  const Vertex stays = mesh.to_vertex_handle(collapse.along);
  Rest rest{p, {}, {}, {}};
  std::vector<uint32_t> vertices;
  for (const Face f : faces[p]) {
    const auto corner = corners(f);
    const auto moves = [&](Vertex v) { return v == goes || v == stays; };
    const auto n = std::count_if(corner.begin(), corner.end(), moves);
    if (n == 2) continue;
    if (n == 0) rest.planes.push_back(number(f));
    for (size_t i = 0; i < 3; ++i) {
      if (moves(corner[i])) {
        rest.fan.emplace_back(at(corner[(i + 1) % 3]), at(corner[(i + 2) % 3]));
      } else {
        vertices.push_back(number(corner[i]));
      }
    }
  }
  keep_distinct(vertices);
  for (const uint32_t v : vertices) rest.points.push_back(at(Vertex(static_cast<int>(v))));
  return rest;
}

std::optional<Collapse> PieceSurgery::State::collapse_along(Halfedge h) {
  if (!is_allowed(h)) return {};
  const Vertex ends[] = {mesh.from_vertex_handle(h), mesh.to_vertex_handle(h)};
  Collapse collapse{h, {}, {}, {}};
  for (const Vertex end : ends) {
    for (const Face f : mesh.vf_range(end)) {
      collapse.pieces.push_back(piece(f));
      if (!has_corner(f, ends[0]) || !has_corner(f, ends[1])) collapse.moving.push_back(f);
    }
  }
  keep_distinct(collapse.pieces);
  if (is_pinched(collapse)) return {};
  for (const uint32_t p : collapse.pieces) {
    Rest rest = rest_of(p, collapse);
    if (!rest.fan.empty() || !rest.planes.empty()) collapse.rests.push_back(std::move(rest));
  }
  if (collapse.rests.empty()) return {};
  return collapse;
}

/// The places that keep all pieces convex, as half-spaces: below the planes of the faces that stay,
/// and such that no vertex of a piece lies above a plane through the place and the side of a face.
std::vector<Plane> PieceSurgery::State::half_spaces(const Collapse& collapse) const {
  std::vector<Plane> spaces;
  for (const Rest& rest : collapse.rests) {
    if (rest.fan.empty()) continue;
    for (const uint32_t f : rest.planes) spaces.push_back(planes[f]);
    for (const auto& [a, b] : rest.fan) {
      for (const Vec3& w : rest.points) {
        if (w == a || w == b) continue;
        const Vec3 normal = cross(w - a, b - a);
        const double length = norm(normal);
        if (length > 0) spaces.push_back({normal / length, dot(normal, a) / length});
      }
    }
    if (spaces.size() > kMostHalfSpaces) return {};
  }
  return spaces;
}

bool PieceSurgery::State::keeps_convex(const Rest& rest, const Vec3& p) const {
  if (rest.fan.empty()) return true;
  for (const uint32_t f : rest.planes) {
    if (planes[f].above(p) > margin) return false;
  }
  for (const auto& [a, b] : rest.fan) {
    const Plane plane = plane_through(a, b, p);
    for (const Vec3& w : rest.points) {
      if (plane.above(w) > margin) return false;
    }
  }
  return true;
}

/// Whether no triangle turns over or becomes a sliver.
bool PieceSurgery::State::keeps_normals(const Collapse& collapse, const Vec3& p) const {
  const Vertex goes = mesh.from_vertex_handle(collapse.along);
  const Vertex stays = mesh.to_vertex_handle(collapse.along);
  return std::all_of(collapse.moving.begin(), collapse.moving.end(), [&](Face f) {
    std::array<Vec3, 3> corner;
    size_t i = 0;
    for (const Vertex v : corners(f)) corner[i++] = v == goes || v == stays ? p : at(v);
    const Vec3 normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
    const double longest =
        std::max({norm_squared(corner[1] - corner[0]), norm_squared(corner[2] - corner[1]),
                  norm_squared(corner[0] - corner[2])});
    return norm(normal) > kSliver * longest &&
           dot(normal, planes[number(f)].normal) > kTurn * norm(normal);
  });
}

bool PieceSurgery::State::fits(const Collapse& collapse, const Vec3& p) const {
  return keeps_normals(collapse, p) &&
         std::all_of(collapse.rests.begin(), collapse.rests.end(),
                     [&](const Rest& rest) { return keeps_convex(rest, p); });
}

std::optional<Vec3> PieceSurgery::State::place_of(const Collapse& collapse) const {
  const Vertex goes = mesh.from_vertex_handle(collapse.along);
  const Vertex stays = mesh.to_vertex_handle(collapse.along);
  Quadric quadric;
  const Vec3 best = best_place(goes, stays, quadric);
  const auto may_be = [&](const Vec3& p) {
    return quadric.distance(p) <= most_off && fits(collapse, p);
  };
  if (!mesh.is_boundary(stays)) {
    if (may_be(best)) return best;
    const std::vector<Plane> spaces = half_spaces(collapse);
    if (!spaces.empty()) {
      const Vec3 moved = into_half_spaces(best, spaces, 0.5 * margin);
      if (may_be(moved)) return moved;
    }
    for (const Vec3& p : {at(goes), 0.5 * (at(stays) + at(goes))}) {
      if (may_be(p)) return p;
    }
  }
  return may_be(at(stays)) ? std::optional(at(stays)) : std::nullopt;
}

/// The piece without faces becomes a part of that of its neighbours which looks most like it.
void PieceSurgery::State::give_away(uint32_t p,
                                    const std::vector<std::pair<uint32_t, Vec3>>& beside,
                                    const Vec3& n) {
  uint32_t heir = ~0u;
  double most = -2;
  for (const auto& [other, normal] : beside) {
    if (other == p || faces[other].empty() || !(dot(normal, n) > most)) continue;
    heir = other;
    most = dot(normal, n);
  }
  joined_to[p] = heir;
  members[heir].insert(members[heir].end(), members[p].begin(), members[p].end());
  members[p].clear();
  has_moved[heir] = true;
  --n_pieces;
}

void PieceSurgery::State::perform(const Collapse& collapse, const Vec3& p) {
  const Vertex stays = mesh.to_vertex_handle(collapse.along);
  quadrics[number(stays)].add(quadrics[number(mesh.from_vertex_handle(collapse.along))]);
  std::vector<std::pair<uint32_t, Vec3>> beside;
  for (const Face f : collapse.moving) beside.emplace_back(piece(f), planes[number(f)].normal);
  std::vector<std::pair<uint32_t, Vec3>> gone;
  for (const uint32_t q : collapse.pieces) {
    gone.emplace_back(q, planes[number(faces[q][0])].normal);
  }
  mesh.collapse(collapse.along);
  mesh.set_point(stays, {p.x, p.y, p.z});
  for (const uint32_t q : collapse.pieces) {
    has_moved[q] = true;
    std::erase_if(faces[q], [&](Face f) { return mesh.status(f).deleted(); });
  }
  for (const auto& [q, normal] : gone) {
    if (faces[q].empty()) give_away(q, beside, normal);
  }
  for (const Face f : mesh.vf_range(stays)) {
    const auto corner = corners(f);
    planes[number(f)] = plane_through(at(corner[0]), at(corner[1]), at(corner[2]));
  }
}

bool PieceSurgery::State::try_edge(Edge e) {
  Halfedge h = mesh.halfedge_handle(e, 0);
  if (mesh.is_boundary(mesh.from_vertex_handle(h))) h = mesh.opposite_halfedge_handle(h);
  const std::optional<Collapse> collapse = collapse_along(h);
  if (!collapse) return false;
  const std::optional<Vec3> place = place_of(*collapse);
  if (!place) return false;
  const Vertex stays = mesh.to_vertex_handle(h);
  perform(*collapse, *place);
  offer_around(stays);
  merge_around(stays);
  return true;
}

std::vector<Vec3> PieceSurgery::State::points_of(const std::vector<Face>& of) const {
  std::vector<uint32_t> vertices;
  for (const Face f : of) {
    for (const Vertex v : corners(f)) vertices.push_back(number(v));
  }
  keep_distinct(vertices);
  std::vector<Vec3> points;
  for (const uint32_t v : vertices) points.push_back(at(Vertex(static_cast<int>(v))));
  return points;
}

/// Whether none of the points lies above one of the faces.
bool PieceSurgery::State::is_convex(const std::vector<Face>& of,
                                    const std::vector<Vec3>& points) const {
  return std::all_of(of.begin(), of.end(), [&](Face f) {
    const Plane& plane = planes[number(f)];
    return std::all_of(points.begin(), points.end(),
                       [&](const Vec3& p) { return plane.above(p) <= margin; });
  });
}

/// Whether the two have as many vertices and edges as a disc (V − E + F = 1) or a closed surface.
bool PieceSurgery::State::is_disc(uint32_t a, uint32_t b) const {
  std::set<uint32_t> vertices, edges;
  for (const uint32_t p : {a, b}) {
    for (const Face f : faces[p]) {
      for (const auto h : mesh.fh_range(f)) {
        edges.insert(number(mesh.edge_handle(h)));
        vertices.insert(number(mesh.to_vertex_handle(h)));
      }
    }
  }
  const size_t n = vertices.size() + faces[a].size() + faces[b].size();
  return n == edges.size() + 1 || n == edges.size() + 2;
}

/// Whether other surface lies in the hull of both, deeper than detail of this level.
bool PieceSurgery::State::is_entered(uint32_t a, uint32_t b, const std::vector<Vec3>& points) {
  HullData hull;
  try {
    hull = hull_of_points(points).hull;
  } catch (const InputError&) {
    return false;  // on a line: nothing can lie in it
  }
  const Box box = box_around(points);
  double edge = 0, n = 0;
  for (const uint32_t p : {a, b}) {
    for (const Face f : faces[p]) {
      for (const auto h : mesh.fh_range(f)) {
        edge += norm(at(mesh.to_vertex_handle(h)) - at(mesh.from_vertex_handle(h))), n += 1;
      }
    }
  }
  const double deep = std::max(kEntered * edge / n, margin);
  CutPolygon part;
  return any_near(boxes, box, [&](uint32_t t) {
    const uint32_t owner = root(leaf_of[t]);
    if (owner == a || owner == b) return false;
    part.p.clear();
    for (const uint32_t v : original.triangles[t]) part.p.push_back(original.vertices[v]);
    return std::all_of(hull.faces.begin(), hull.faces.end(), [&](const HullFace& face) {
      return part.cut({face.normal, face.offset}, deep);
    });
  });
}

bool PieceSurgery::State::may_merge(uint32_t a, uint32_t b) {
  if (faces[a].size() + faces[b].size() > kMostTriangles) return false;
  std::vector<Vec3> points = points_of(faces[a]);
  if (!is_convex(faces[b], points)) return false;
  const std::vector<Vec3> of_b = points_of(faces[b]);
  if (!is_convex(faces[a], of_b) || !is_disc(a, b)) return false;
  points.insert(points.end(), of_b.begin(), of_b.end());
  return !is_entered(a, b, points);
}

/// The smaller one becomes a part of the other.
void PieceSurgery::State::merge(uint32_t a, uint32_t b) {
  if (faces[a].size() < faces[b].size()) std::swap(a, b);
  for (const Face f : faces[b]) piece_of[number(f)] = a;
  faces[a].insert(faces[a].end(), faces[b].begin(), faces[b].end());
  members[a].insert(members[a].end(), members[b].begin(), members[b].end());
  faces[b].clear();
  members[b].clear();
  joined_to[b] = a;
  --n_pieces;
}

/// Merges the pieces on both sides of an edge if they may.
void PieceSurgery::State::merge_over(Edge e) {
  const Halfedge h = mesh.halfedge_handle(e, 0), back = mesh.opposite_halfedge_handle(h);
  if (mesh.is_boundary(h) || mesh.is_boundary(back)) return;
  const Face left = mesh.face_handle(h), right = mesh.face_handle(back);
  if (piece(left) == piece(right)) return;
  // cheap, and most pieces end at an edge that is concave
  const Vec3 beyond = at(mesh.to_vertex_handle(mesh.next_halfedge_handle(back)));
  if (planes[number(left)].above(beyond) > margin) return;
  if (may_merge(piece(left), piece(right))) merge(piece(left), piece(right));
}

void PieceSurgery::State::merge_around(Vertex v) {
  for (const auto h : mesh.voh_range(v)) {
    merge_over(mesh.edge_handle(h));
    if (!mesh.is_boundary(h)) merge_over(mesh.edge_handle(mesh.next_halfedge_handle(h)));
  }
}

PieceSurgery::PieceSurgery(const TriangleMesh& mesh, const SurfacePieces& pieces)
    : state_(std::make_unique<State>()) {
  state_->read(mesh, pieces);
}

PieceSurgery::~PieceSurgery() = default;

size_t PieceSurgery::n_pieces() const {
  return state_->n_pieces;
}

bool PieceSurgery::simplify(size_t target) {
  State& state = *state_;
  if (!state.is_sound) return false;
  for (const Edge e : state.mesh.edges()) {
    if (!state.mesh.status(e).deleted()) state.offer(e);
  }
  while (state.n_pieces > target) {
    if (state.offers.empty()) return false;
    const State::Offer offer = state.offers.top();
    state.offers.pop();
    const Edge e(static_cast<int>(offer.edge));
    if (offer.stamp == state.stamps[offer.edge] && !state.mesh.status(e).deleted()) {
      state.try_edge(e);
    }
  }
  return true;
}

std::vector<SimplePiece> PieceSurgery::take_level() {
  State& state = *state_;
  std::vector<std::pair<uint32_t, uint32_t>> order;  // by lowest member
  for (uint32_t p = 0; p < state.faces.size(); ++p) {
    if (state.faces[p].empty()) continue;
    std::sort(state.members[p].begin(), state.members[p].end());
    order.emplace_back(state.members[p][0], p);
  }
  std::sort(order.begin(), order.end());
  std::vector<SimplePiece> level;
  for (const auto& [lowest, p] : order) {
    SimplePiece piece;
    piece.members = std::exchange(state.members[p], {static_cast<uint32_t>(level.size())});
    piece.has_moved = state.has_moved[p];
    state.has_moved[p] = false;
    for (const Face f : state.faces[p]) {
      const auto [a, b, c] = state.corners(f);
      piece.corners.push_back({state.at(a), state.at(b), state.at(c)});
      piece.triangles.push_back(number(f));
    }
    level.push_back(std::move(piece));
  }
  return level;
}

}  // namespace haptic
