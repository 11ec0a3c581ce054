// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/convex/expanding_polytope.h"

#include <array>
#include <cmath>
#include <cstddef>

namespace haptic {
namespace {

constexpr size_t kMaxCorners = 200;            // of the polytope: each expansion adds one
constexpr size_t kMaxFaces = 2 * kMaxCorners;  // of those alive at once: 2 V − 4
constexpr double kSettled = 1e-12;  // gain of an expansion, in shares of the size, that is rounding

struct DifferenceCorner {
  Vec3 p_A;  // of A ⊕ (−B)
  uint32_t a, b;
};

struct Face {
  std::array<uint16_t, 3> corners, neighbours;  // neighbour k is beyond the edge from corner k
  Vec3 normal;
  double distance;
  bool alive;
  bool settled;  // no support lies beyond it
};

/// The polytope and the search for its nearest face.
class Polytope {
 public:
  explicit Polytope(const HullPair& pair) : pair_(pair), overlay_(pair) {}

  PolytopeDepth search();

 private:
  bool begin();
  uint16_t add_corner(const Vec3& direction);
  uint16_t add_face(uint16_t a, uint16_t b, uint16_t c);
  int nearest_face() const;
  bool expand(uint16_t face, uint16_t corner);
  bool carve(uint16_t face, uint16_t from, const Vec3& p);

  struct Rim {
    uint16_t from, to, outside;
  };

  const HullPair& pair_;
  GaussOverlay overlay_;
  std::array<DifferenceCorner, kMaxCorners> corners_;
  std::array<Face, kMaxFaces> faces_;
  std::array<uint16_t, kMaxFaces> free_;
  std::array<Rim, kMaxFaces> rim_;
  std::array<uint16_t, kMaxFaces> made_;
  size_t n_corners_ = 0, n_faces_ = 0, n_free_ = 0, n_rim_ = 0;
  double size_ = 0;
  PolytopeDepth best_;
};

/// Adds the support of a direction, which also bounds the depth.
uint16_t Polytope::add_corner(const Vec3& direction) {
  const Vec3 unit = normalized(direction);
  DifferenceCorner& corner = corners_[n_corners_];
  corner.a = n_corners_ > 0 ? corners_[n_corners_ - 1].a : 0;
  corner.b = n_corners_ > 0 ? corners_[n_corners_ - 1].b : 0;
  const double reach = overlay_.support(unit, corner.a, corner.b);
  corner.p_A = pair_.vertex_a(corner.a) - pair_.vertex_b(corner.b);
  if (n_corners_ == 0 || reach < best_.depth) best_ = {unit, reach, corner.a, corner.b, false};
  return static_cast<uint16_t>(n_corners_++);
}

uint16_t Polytope::add_face(uint16_t a, uint16_t b, uint16_t c) {
  const uint16_t at = n_free_ > 0 ? free_[--n_free_] : static_cast<uint16_t>(n_faces_++);
  const Vec3 &p = corners_[a].p_A, &q = corners_[b].p_A, &r = corners_[c].p_A;
  Face& face = faces_[at];
  face.corners = {a, b, c};
  face.normal = normalized(cross(q - p, r - p));
  face.distance = dot(face.normal, p);
  face.alive = true;
  face.settled = false;
  return at;
}

/// A tetrahedron of supports; false where the Minkowski difference is flat.
bool Polytope::begin() {
  const Vec3 way = pair_.p_AB + pair_.R_AB * pair_.b.vertices[0] - pair_.a.vertices[0];
  const Vec3 first = norm_squared(way) > 0 ? way : Vec3{1, 0, 0};
  add_corner(first);
  add_corner(-first);
  const Vec3 p = corners_[0].p_A, line = corners_[1].p_A - p;
  size_ = norm(line);
  if (!(size_ > 0)) return false;
  const Vec3 across = any_perpendicular(normalized(line));
  uint16_t third = add_corner(across);
  const auto off_line = [&](uint16_t c) { return norm(cross(line, corners_[c].p_A - p)); };
  const uint16_t opposite = add_corner(-across);
  if (off_line(opposite) > off_line(third)) third = opposite;
  if (!(off_line(third) > kSettled * size_ * size_)) {
    third = add_corner(cross(across, line));
    const uint16_t other = add_corner(-cross(across, line));
    if (off_line(other) > off_line(third)) third = other;
  }
  const Vec3 normal = normalized(cross(line, corners_[third].p_A - p));
  uint16_t above = add_corner(normal);
  const uint16_t below = add_corner(-normal);
  const auto height = [&](uint16_t c) { return dot(normal, corners_[c].p_A - p); };
  if (-height(below) > height(above)) above = below;
  if (!(std::fabs(height(above)) > kSettled * size_)) return false;
  const bool flip = height(above) > 0;
  const uint16_t a = 0, b = flip ? third : uint16_t{1}, c = flip ? uint16_t{1} : third;
  // outward seen from above's side: a, b, c is the base
  const uint16_t base = add_face(a, b, c), ab = add_face(b, a, above), bc = add_face(c, b, above),
                 ca = add_face(a, c, above);
  faces_[base].neighbours = {ab, bc, ca};
  faces_[ab].neighbours = {base, ca, bc};
  faces_[bc].neighbours = {base, ab, ca};
  faces_[ca].neighbours = {base, bc, ab};
  return true;
}

int Polytope::nearest_face() const {
  int nearest = -1;
  for (size_t i = 0; i < n_faces_; ++i) {
    const Face& face = faces_[i];
    if (!face.alive || face.settled || !(face.distance < best_.depth)) continue;
    if (nearest < 0 || face.distance < faces_[static_cast<size_t>(nearest)].distance) {
      nearest = static_cast<int>(i);
    }
  }
  return nearest;
}

/// Removes the faces that see the point, from the one that is entered from a neighbour, and notes
/// the rim around them in order; false where there is no room.
bool Polytope::carve(uint16_t at, uint16_t from, const Vec3& p) {
  // depth first with a stack of our own: each entry is a face and the edge it was entered by
  struct Entry {
    uint16_t face, first, done;
  };
  std::array<Entry, kMaxFaces> stack;
  size_t n = 0;
  faces_[at].alive = false;
  stack[n++] = {at, from, 0};
  while (n > 0) {
    Entry& entry = stack[n - 1];
    const Face& face = faces_[entry.face];
    if (entry.done == 3) {
      free_[n_free_++] = entry.face;
      --n;
      continue;
    }
    const size_t k = (entry.first + entry.done++) % 3;
    const uint16_t next = face.neighbours[k];
    if (!faces_[next].alive) continue;
    if (dot(faces_[next].normal, p) - faces_[next].distance > kSettled * size_) {
      faces_[next].alive = false;
      uint16_t back = 0;
      while (faces_[next].corners[back] != face.corners[(k + 1) % 3]) ++back;
      if (n == stack.size()) return false;
      stack[n++] = {next, back, 1};  // the edge it was entered by is done
    } else {
      if (n_rim_ == rim_.size()) return false;
      rim_[n_rim_++] = {face.corners[k], face.corners[(k + 1) % 3], next};
    }
  }
  return true;
}

/// Joins a corner to the rim of the faces that it sees.
bool Polytope::expand(uint16_t face, uint16_t corner) {
  n_rim_ = 0;
  if (!carve(face, 0, corners_[corner].p_A) || n_rim_ < 3) return false;
  if (n_faces_ + n_rim_ > faces_.size() + n_free_) return false;
  for (size_t i = 0; i < n_rim_; ++i) {
    const Rim& rim = rim_[i];
    // in order, each begins where the one before ended
    if (rim.to != rim_[(i + 1) % n_rim_].from) return false;
    made_[i] = add_face(rim.from, rim.to, corner);
  }
  for (size_t i = 0; i < n_rim_; ++i) {
    const Rim& rim = rim_[i];
    faces_[made_[i]].neighbours = {rim.outside, made_[(i + 1) % n_rim_],
                                   made_[(i + n_rim_ - 1) % n_rim_]};
    Face& outside = faces_[rim.outside];
    for (size_t k = 0; k < 3; ++k) {
      if (outside.corners[k] == rim.to && outside.corners[(k + 1) % 3] == rim.from) {
        outside.neighbours[k] = made_[i];
      }
    }
  }
  return true;
}

PolytopeDepth Polytope::search() {
  if (!begin()) {
    best_.exact = true;  // flat: the supports of its normals are among those that were tried
    return best_;
  }
  while (n_corners_ < kMaxCorners) {
    const int at = nearest_face();
    if (at < 0 || best_.depth < 0) {
      best_.exact = true;  // no face is nearer than a direction's support: that is the smallest
      return best_;
    }
    Face& face = faces_[static_cast<size_t>(at)];
    const uint16_t corner = add_corner(face.normal);
    if (dot(face.normal, corners_[corner].p_A) - face.distance <= kSettled * size_) {
      face.settled = true;
      --n_corners_;
    } else if (!expand(static_cast<uint16_t>(at), corner)) {
      return best_;
    }
  }
  return best_;
}

}  // namespace

PolytopeDepth expand_polytope(const HullPair& pair) {
  return Polytope(pair).search();
}

}  // namespace haptic
