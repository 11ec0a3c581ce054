// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for contact/query/convex/piece_front.cpp and piece_contact.cpp.
#include "contact/query/convex/piece_front.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "contact/query/proximity/triangle_pairs.h"
#include "tests/support/convex/split_tree.h"

namespace haptic {
namespace {

using test::split_tree;
using test::SplitTree;

constexpr uint32_t kPlenty = 1 << 15;   // node pairs
constexpr double kPieceReach = 0.3e-3;  // δ [m]

/// Sphere whose radius varies by ±5 %.
Soup bumpy_ball(double bump_trees) {
  Soup soup = make_icosphere(0.02, 3);
  for (Vec3& v : soup.vertices) {
    const Vec3 u = (bump_trees / 0.02) * v;
    v = (1 + 0.05 * std::sin(u.x) * std::sin(u.y) * std::sin(u.z)) * v;
  }
  return soup;
}

/// Two bumpy balls, one of which turns and slides on the other, half a millimetre or so deep.
struct BumpTrees {
  MeshShapeData mesh_a = build_shape(bumpy_ball(9)), mesh_b = build_shape(bumpy_ball(8));
  SplitTree a = split_tree({mesh_a.mesh.vertices, mesh_a.mesh.triangles}, 6);
  SplitTree b = split_tree({mesh_b.mesh.vertices, mesh_b.mesh.triangles}, 6);

  std::vector<TriangleMeeting> meetings(const Pose& X_AB) const {
    const TriangleMesh of_a = mesh_a.mesh.view(), of_b = mesh_b.mesh.view();
    std::vector<TrianglePair> pairs(1 << 14);
    pairs.resize(triangle_pairs(mesh_a.view(), mesh_b.view(), X_AB, pairs));
    std::vector<TriangleMeeting> meetings;
    for (const TrianglePair& pair : pairs) {
      const Vec3 way = of_a.face_normals[pair.a] - rotate(X_AB.q, of_b.face_normals[pair.b]);
      meetings.push_back({a.leaf_of[pair.a], b.leaf_of[pair.b], {}, normalized(way), 1e-3});
    }
    return meetings;
  }

  static Pose at(double t) {
    return {{0.0394 * std::cos(0.4 * t), 0.0394 * std::sin(0.4 * t), 0.001 * std::sin(7 * t)},
            from_rotation_vector({0.5 * t, 0.3, -0.2 * t})};
  }
};

const BumpTrees& bump_trees() {
  static const BumpTrees made;
  return made;
}

RefineOptions options_with(double threshold) {
  RefineOptions options;
  options.threshold = threshold;
  options.tolerance = kPieceReach;
  return options;
}

std::span<const PieceContact> contacts_at(PieceFront& front, const Pose& X_AB,
                                          const RefineOptions& options) {
  front.update(X_AB, options);
  return front.contacts(bump_trees().meetings(X_AB));
}

/// A contact by its pieces, and its place and depth in nanometres.
using Key = std::tuple<uint32_t, uint32_t, double, double, double, double>;

std::multiset<Key> keys_of(std::span<const PieceContact> contacts) {
  std::multiset<Key> keys;
  const auto rounded = [](double v) { return std::round(v * 1e9); };
  for (const PieceContact& c : contacts) {
    keys.insert({c.piece_a, c.piece_b, rounded(c.depth), rounded(c.point_b_A.x),
                 rounded(c.point_b_A.y), rounded(c.point_b_A.z)});
  }
  return keys;
}

/// Every pair of leaves, each asked without a state.
std::multiset<Key> all_leaf_pairs(const PieceTree& a, const PieceTree& b, const Pose& X_AB) {
  std::map<std::pair<uint32_t, uint32_t>, LocalDepth> local;
  for (const TriangleMeeting& m : bump_trees().meetings(X_AB)) {
    LocalDepth& under = local[{m.leaf_a, m.leaf_b}];
    under.deepest = std::max(under.deepest, m.depth);
    under.sum += m.depth;
    under.way_A += m.depth * m.normal_A;
  }
  std::vector<PieceContact> contacts;
  for (uint32_t i = 0; i < a.pieces.size(); ++i) {
    for (uint32_t k = 0; k < b.pieces.size(); ++k) {
      if (a.pieces[i].n_children + b.pieces[k].n_children > 0) continue;
      ConvexPairState state{};
      const PieceTouch touch = touch_of(a, i, b, k, X_AB, state);
      std::array<PieceContact, kMostOfPair> found;
      const size_t n =
          piece_contacts(a, i, b, k, X_AB, touch, &local[{i, k}], {kPieceReach, 0}, found);
      contacts.insert(contacts.end(), found.begin(), found.begin() + static_cast<ptrdiff_t>(n));
    }
  }
  return keys_of(contacts);
}

/// Σ d n over the contacts, divided by Σ d.
Vec3 push_of(std::span<const PieceContact> contacts) {
  Vec3 sum;
  double weight = 0;
  for (const PieceContact& c : contacts) {
    if (!(c.depth > 0)) continue;
    sum += c.depth * c.depth * c.normal_A;
    weight += c.depth;
  }
  return weight > 0 ? sum / weight : Vec3{};
}

}  // namespace

TEST_CASE("piece front: with the threshold 0 it is the exact query") {
  const PieceTree a = bump_trees().a.view(), b = bump_trees().b.view();
  REQUIRE(a.level_pieces[0] > 50);
  PieceFront front(a, b, kPlenty);
  size_t most = 0;
  for (int tick = 0; tick < 4; ++tick) {
    const Pose X_AB = BumpTrees::at(0.3 * tick);
    // with the states of the last pose the depth of a pair may be that of another local minimum
    front.forget();
    const auto found = keys_of(contacts_at(front, X_AB, options_with(0)));
    CAPTURE(tick, found.size());
    CHECK_FALSE(front.is_truncated());
    CHECK(found == all_leaf_pairs(a, b, X_AB));
    most = std::max(most, found.size());
  }
  CHECK(most > 10);
}

TEST_CASE("piece front: free space has no contact, and neither has what is not finite") {
  PieceFront front(bump_trees().a.view(), bump_trees().b.view(), kPlenty);
  CHECK(contacts_at(front, {{0.06, 0, 0}, {}}, options_with(0)).empty());
  CHECK(front.work() == 1);
  CHECK(contacts_at(front, {{0.0601, 0, 0}, {}}, options_with(0)).empty());
  CHECK(front.work() == 0);
  CHECK(contacts_at(front, {{NAN, 0, 0}, {}}, options_with(0)).empty());
  RefineOptions unsound = options_with(0);
  unsound.tolerance = NAN;
  CHECK(contacts_at(front, {{0.0394, 0, 0}, {}}, unsound).empty());
  CHECK_FALSE(contacts_at(front, {{0.0394, 0, 0}, {}}, options_with(0)).empty());
}

TEST_CASE("piece front: a budget that suffices again brings the threshold back") {
  PieceFront front(bump_trees().a.view(), bump_trees().b.view(), kPlenty);
  RefineOptions options = options_with(5e-6);
  options.budget = 20;
  for (int i = 0; i < 3; ++i) front.update(BumpTrees::at(1e-4 * i), options);
  CHECK(front.is_truncated());
  CHECK(front.threshold() > 5e-6);
  options.budget = 100'000;
  for (int i = 0; i < 400; ++i) front.update(BumpTrees::at(2e-3), options);
  CHECK(front.threshold() == 5e-6);
  PieceFront fresh(bump_trees().a.view(), bump_trees().b.view(), kPlenty);
  CHECK(keys_of(contacts_at(front, BumpTrees::at(2e-3), options)) ==
        keys_of(contacts_at(fresh, BumpTrees::at(2e-3), options)));
}

TEST_CASE("piece front: memory that ends is flagged, and coarse pairs stay in contact") {
  PieceFront front(bump_trees().a.view(), bump_trees().b.view(), 64);
  bool any = false;
  for (int tick = 0; tick < 50; ++tick) {
    any |= !contacts_at(front, BumpTrees::at(0.005 * tick), options_with(0)).empty();
    CHECK(front.size() <= 64);
    CHECK((front.is_truncated() || front.threshold() > 0));
  }
  CHECK(any);
}

TEST_CASE("piece front: coherence saves work and finds the same pairs") {
  PieceFront kept(bump_trees().a.view(), bump_trees().b.view(), kPlenty);
  size_t kept_work = 0, fresh_work = 0;
  for (int tick = 0; tick < 200; ++tick) {
    const Pose X_AB = BumpTrees::at(0.001 * tick);
    const auto found = contacts_at(kept, X_AB, options_with(0));
    kept_work += kept.work();
    if (tick % 20 != 19) continue;
    PieceFront fresh(bump_trees().a.view(), bump_trees().b.view(), kPlenty);
    const auto anew = contacts_at(fresh, X_AB, options_with(0));
    CHECK(kept.near() == fresh.near());
    CHECK(norm(push_of(found) - push_of(anew)) < 0.05 * norm(push_of(anew)));
    fresh_work += 20 * fresh.work();
  }
  CHECK(2 * kept_work < fresh_work);
}

TEST_CASE("piece front: contacts that are carried follow both surfaces") {
  PieceFront asked(bump_trees().a.view(), bump_trees().b.view(), kPlenty);
  PieceFront carried(bump_trees().a.view(), bump_trees().b.view(), kPlenty);
  RefineOptions carrying = options_with(0);
  carrying.carry = 20e-6;
  size_t asked_work = 0, carried_work = 0;
  double error = 0, push = 0;
  for (int tick = 0; tick < 200; ++tick) {
    const Pose X_AB = BumpTrees::at(1e-4 * tick);
    const Vec3 exact = push_of(contacts_at(asked, X_AB, options_with(0)));
    error += norm(push_of(contacts_at(carried, X_AB, carrying)) - exact);
    push += norm(exact);
    asked_work += asked.work();
    carried_work += carried.work();
  }
  CHECK(3 * carried_work < asked_work);
  CHECK(push > 0);
  CHECK(error < 0.1 * push);
}

TEST_CASE("piece front: detail that slides past faster than the bandwidth is not refined") {
  const auto near_with = [](double speed) {
    PieceFront front(bump_trees().a.view(), bump_trees().b.view(), kPlenty);
    RefineOptions options = options_with(0);
    options.bandwidth = 100;
    options.speed = speed;
    front.update(BumpTrees::at(0), options);
    return front.size();
  };
  CHECK(near_with(0) > near_with(1));
  CHECK(near_with(1) > near_with(10));
}

TEST_CASE("haptic error: the volume of what is missing over the area of the contact") {
  Piece fine{}, coarse{};
  fine.radius = coarse.radius = 1;
  fine.area = 2e-4;
  coarse.area = 4e-4;
  coarse.n_children = 2;
  coarse.deviation = 1e-3;
  coarse.resolution = 100;
  const std::array<uint32_t, 2> levels{4, 2};
  PieceTree tree;
  tree.level_pieces = levels;
  // 1 mm over 1 cm², spread over 4 cm²
  CHECK(haptic_error(tree, fine, tree, coarse) == Approx(0.25e-3));
  CHECK(haptic_error(tree, fine, tree, fine) == 0);
  coarse.level = 2;  // above the coarsest level: a bounding volume
  CHECK(std::isinf(haptic_error(tree, fine, tree, coarse)));
}

}  // namespace haptic
