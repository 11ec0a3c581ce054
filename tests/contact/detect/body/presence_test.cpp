// SPDX-License-Identifier: GPL-3.0-or-later
// Convex pieces of concave bodies, judged by their triangles: contact/detect/body/pieces.cpp and
// contact/query/convex/piece_contact.cpp.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <numbers>

#include "contact/bake/convex/piece_tree.h"
#include "contact/detect/body/cluster_contact.h"
#include "contact/detect/body/exact.h"
#include "contact/detect/body/pieces.h"
#include "contact/shape/mesh/tool_body.h"
#include "proto/math/units.h"
#include "servo/solve/body/soft_proxy.h"
#include "tests/support/cgal_pairs.h"
#include "tests/support/convex/meshes.h"
#include "tests/support/meshes.h"

namespace haptic {
namespace {

using test::Random;

constexpr double kSpring = 1000;    // of a contact [N/m]
constexpr double kAhead = 0.5e-3;   // δ [m]
constexpr double kDeep = 0.5e-3;    // overlap from which on a contact must push [m]
constexpr double kHandSpeed = 2;    // [m/s]
constexpr double kHandTurns = 10;   // [rad/s]
constexpr double kStroke = 3e-3;    // how far a hand goes in [m]
constexpr double kOfOneMind = 0.6;  // |Σ| / Σ|.| of pushes that have a direction together
constexpr size_t kKinds = 9;        // of meshes

void add_quad(Soup& soup, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
  soup.triangles.push_back({a, b, c});
  soup.triangles.push_back({a, c, d});
}

/// A closed block whose top is a field of random heights.
Soup height_block(Random& random, uint32_t n, double side, double rough) {
  Soup soup;
  const double cells = n;
  for (const double sign : {1.0, -1.0}) {
    for (uint32_t i = 0; i <= n; ++i) {
      for (uint32_t k = 0; k <= n; ++k) {
        soup.vertices.push_back({side * (i / cells - 0.5), side * (k / cells - 0.5),
                                 sign > 0 ? random.uniform(0, rough) : -0.4 * side});
      }
    }
  }
  const uint32_t low = (n + 1) * (n + 1);
  const auto at = [n](uint32_t i, uint32_t k) { return i * (n + 1) + k; };
  for (uint32_t i = 0; i < n; ++i) {
    for (uint32_t k = 0; k < n; ++k) {
      const uint32_t a = at(i, k), b = at(i + 1, k), c = at(i + 1, k + 1), d = at(i, k + 1);
      add_quad(soup, a, b, c, d);
      add_quad(soup, low + a, low + d, low + c, low + b);
    }
    add_quad(soup, low + at(i, 0), low + at(i + 1, 0), at(i + 1, 0), at(i, 0));
    add_quad(soup, at(i, n), at(i + 1, n), low + at(i + 1, n), low + at(i, n));
    add_quad(soup, at(0, i), at(0, i + 1), low + at(0, i + 1), low + at(0, i));
    add_quad(soup, low + at(n, i), low + at(n, i + 1), at(n, i + 1), at(n, i));
  }
  return soup;
}

/// A prism over a square that is twisted about its axis as it rises: its sides are saddles.
Soup twisted_prism(uint32_t layers, double side, double height, double twist) {
  Soup soup;
  for (uint32_t i = 0; i <= layers; ++i) {
    const double share = static_cast<double>(i) / layers;
    for (uint32_t k = 0; k < 4; ++k) {
      const double angle = twist * share + 0.5 * std::numbers::pi * k;
      soup.vertices.push_back(
          {0.5 * side * std::cos(angle), 0.5 * side * std::sin(angle), height * (share - 0.5)});
    }
  }
  for (uint32_t i = 0; i < layers; ++i) {
    for (uint32_t k = 0; k < 4; ++k) {
      const uint32_t a = 4 * i + k, b = 4 * i + (k + 1) % 4;
      add_quad(soup, a, b, b + 4, a + 4);
    }
  }
  const uint32_t top = 4 * layers;
  add_quad(soup, 3, 2, 1, 0);
  add_quad(soup, top, top + 1, top + 2, top + 3);
  return soup;
}

Soup concave_mesh(Random& random, size_t kind) {
  const auto few = [&](size_t from, size_t n) {
    return static_cast<uint32_t>(from + random.index(n));
  };
  const double size = random.uniform(0.015, 0.03);
  switch (kind) {
    case 0:
      return height_block(random, few(3, 6), 0.08, random.uniform(0.1, 0.6) * size);
    case 1:
      return twisted_prism(few(2, 8), size, 2 * size, random.uniform(-2, 2));
    case 2:
      return test::make_l_shape(2 * size, random.uniform(0.01, 0.04));
    case 3:
      return test::make_dented_ball(size, few(2, 2), random.uniform(0.4, 1), 0.3 * size);
    case 4:
      return test::make_torus(size, random.uniform(0.2, 0.5) * size, few(12, 20), few(6, 8));
    case 5:
      return test::make_bumpy_ball(size, few(2, 2), random.uniform(0.02, 0.1), 8);
    case 6:
      return test::make_bumpy_ball(random.index(1000), size, 2);
    case 7:
      return test::load_off("bones.off", 0.08);
    default:
      return test::load_off("couplingdown.off", 0.06);
  }
}

struct Body {
  MeshShapeData shape;
  PieceTreeData pieces;

  explicit Body(const Soup& soup)
      : shape(build_shape(soup)), pieces(build_piece_tree(shape.mesh.view())) {}
};

std::shared_ptr<const Body> concave_body(Random& random) {
  static std::array<std::shared_ptr<const Body>, kKinds> published;
  size_t kind = random.index(kKinds);
  if (kind >= 7 && !published[kind]) {
    const Soup soup = concave_mesh(random, kind);
    if (!soup.triangles.empty()) published[kind] = std::make_shared<Body>(soup);
  }
  // without the published meshes: one of the others
  if (published[kind]) return published[kind];
  return std::make_shared<Body>(concave_mesh(random, kind % 7));
}

/// What all triangles that meet push, as in direct6.
struct Judged {
  Vec3 alone, shared;  // by springs that do not share, and by those that do [N]
  double sum = 0;      // of the forces of those that do not, without their directions [N]
};

Judged judge(const Body& object, const Body& tool, const Pose& X_OT) {
  std::vector<TrianglePair> pairs(1 << 14);
  const size_t n =
      std::min(triangle_pairs(object.shape.view(), tool.shape.view(), X_OT, pairs), pairs.size());
  std::vector<PointPush> pushes(kPushesPerPair * n);
  pushes.resize(pushes_from_pairs(object.shape.mesh.view(), tool.shape.mesh.view(), X_OT,
                                  {pairs.data(), n}, kSpring, pushes));
  Judged judged;
  for (const PointPush& p : pushes) {
    judged.alone += kSpring * p.depth * p.normal_O;
    judged.sum += kSpring * p.depth;
  }
  share_stiffness(pushes, kSpring, 4);
  for (const PointPush& p : pushes) judged.shared += p.stiffness * p.depth * p.normal_O;
  return judged;
}

/// By CGAL's predicates.
bool any_meet(const Body& object, const Body& tool, const Pose& X_OT) {
  const TriangleMesh a = object.shape.mesh.view(), b = tool.shape.mesh.view();
  std::vector<std::array<Vec3, 3>> of_a, of_b;
  for (uint32_t t = 0; t < a.triangles.size(); ++t) of_a.push_back(corners_of(a, t));
  for (uint32_t t = 0; t < b.triangles.size(); ++t) of_b.push_back(corners_of(b, t, X_OT));
  return !test::cgal_triangle_pairs(of_a, of_b).empty();
}

/// How often a closed mesh surrounds a point (van Oosterom & Strackee 1983).
double winding(const TriangleMesh& mesh, const Vec3& p) {
  double angle = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]] - p, b = mesh.vertices[t[1]] - p,
               c = mesh.vertices[t[2]] - p;
    const double la = norm(a), lb = norm(b), lc = norm(c);
    angle += 2 * std::atan2(dot(a, cross(b, c)),
                            la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return angle / (4 * std::numbers::pi);
}

double distance_to(const Corners& c, const Vec3& p) {
  const Vec3 normal = normalized(cross(c[1] - c[0], c[2] - c[0]));
  double least = std::fabs(dot(normal, p - c[0]));
  for (size_t i = 0; i < 3; ++i) {
    const Vec3 side = c[(i + 1) % 3] - c[i];
    if (dot(normal, cross(side, p - c[i])) >= 0) continue;
    least = 1;
    for (size_t k = 0; k < 3; ++k) {
      const Vec3 edge = c[(k + 1) % 3] - c[k];
      const double along = std::clamp(dot(p - c[k], edge) / norm_squared(edge), 0.0, 1.0);
      least = std::min(least, norm(p - c[k] - along * edge));
    }
    break;
  }
  return least;
}

/// How deep the vertices of one mesh lie in the other, at most, by brute force [m].
double deepest_vertex(const TriangleMesh& mesh, const TriangleMesh& other, const Pose& X) {
  double deepest = 0;
  for (const Vec3& v : other.vertices) {
    const Vec3 p = X * v;
    const bool is_near = component_max(p, mesh.lower) == p && component_min(p, mesh.upper) == p;
    if (!is_near || winding(mesh, p) < 0.5) continue;
    double depth = 1;
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      depth = std::min(depth, distance_to(corners_of(mesh, t), p));
    }
    deepest = std::max(deepest, depth);
  }
  return deepest;
}

double overlap(const Body& object, const Body& tool, const Pose& X_OT) {
  const TriangleMesh a = object.shape.mesh.view(), b = tool.shape.mesh.view();
  return std::max(deepest_vertex(a, b, X_OT), deepest_vertex(b, a, inverse(X_OT)));
}

/// A pose of the tool in which it just touches, from some side.
bool find_touch(const Body& object, const Body& tool, const Vec3& from, const Quat& q,
                double& distance) {
  std::array<TrianglePair, 1> first;
  double far = 0.2, near = 0;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (far + near);
    const Pose X_OT{middle * from, q};
    (triangle_pairs(object.shape.view(), tool.shape.view(), X_OT, first) > 0 ? near : far) = middle;
  }
  distance = far;
  return near > 0;
}

/// The renderers localized and, with levels of detail, sensation, as a session has them.
class Pieces {
 public:
  Pieces(const Body& object, const Body& tool, bool has_levels)
      : object_(object), tool_(tool), model_(model_of(object, tool)), state_(model_) {
    if (!has_levels) return;
    refine_ = {.threshold = 50e-6, .carry = 20e-6, .budget = 2000};
  }

  const ContactSet& at(const Pose& X_OT) {
    *set_ = {};
    set_->objects.resize(1);
    set_->X_WT = X_OT;
    BodyQuestion question;
    question.X_WT = X_OT;
    question.X_WO.resize(1);
    question.V_WO.resize(1);
    question.reach = kAhead;
    refine_.spread = model_.refine.spread;
    const MeshShape shape = object_.shape.view();
    detect_pieces(model_, refine_, {{&shape, 1}, tool_.shape.view()}, state_, question, *set_);
    return *set_;
  }
  Vec3 force_at(const Pose& X_OT) {
    const ContactSet& set = at(X_OT);
    Vec3 force;
    for (uint32_t i = 0; i < set.n_active; ++i) {
      const Contact& c = set.contacts[i];
      const double depth = dot(c.normal_O, c.object_point_O - X_OT * c.tool_point_T);
      force += c.stiffness * depth * c.normal_O;
    }
    return force;
  }
  /// Whether all that pushes does so within `reach` of the boxes of both [m].
  bool push_near_both(const Pose& X_OT, double reach) const {
    const auto is_near = [reach](const TriangleMesh& mesh, const Vec3& p) {
      const Vec3 nearest = component_max(mesh.lower, component_min(mesh.upper, p));
      return norm(nearest - p) < reach;
    };
    return std::all_of(set_->contacts.begin(), set_->contacts.begin() + set_->n_active,
                       [&](const Contact& c) {
                         return is_near(object_.shape.mesh.view(), X_OT * c.tool_point_T) &&
                                is_near(tool_.shape.mesh.view(), c.tool_point_T);
                       });
  }
  /// The budget or the memory ended: this answer may lack what pushes.
  bool is_cut_short() const { return (set_->flags & kContactIterationLimit) != 0; }

 private:
  static PieceModel model_of(const Body& object, const Body& tool) {
    const TriangleMesh mesh = tool.shape.mesh.view();
    PieceModel model;
    model.tool = tool.pieces.view();
    model.objects = {object.pieces.view()};
    model.stiffness = kSpring;
    model.search = 0.5 * norm(mesh.upper - mesh.lower);
    model.clusters.radius = 0.25 * model.search;
    model.refine.spread = 0.5 * model.clusters.radius;
    model.most_pairs = {1 << 14};
    return model;
  }

  const Body &object_, &tool_;
  PieceModel model_;
  RefineOptions refine_;
  PieceState state_;
  std::unique_ptr<ContactSet> set_ = std::make_unique<ContactSet>();
};

/// A hand that comes in at its speed, 3 mm deeper than the touch, slides, turns and leaves.
struct Stroke {
  Vec3 from, along, turn;
  Quat q;
  double distance = 0;
  bool touches = false;

  Stroke(const Body& object, const Body& tool, Random& random)
      : from(random.direction()),
        along(normalized(cross(from, random.direction()))),
        turn(kHandTurns * random.direction()),
        q(from_rotation_vector(random.uniform(0, 3) * random.direction())),
        touches(find_touch(object, tool, from, q, distance)) {}

  static constexpr double kIn = 0.0125, kThere = 0.05, kOut = 0.04, kRest = 0.2;  // [s]

  ToolMotion at(double t) const {
    const double there = std::clamp(t - kIn, 0.0, kThere);
    const double in = kHandSpeed * (std::min(t, kIn) - std::clamp(t - kIn - kThere, 0.0, kOut));
    ToolMotion hand;
    hand.X_WT.p = (distance + kHandSpeed * kIn - kStroke - in) * from + 0.1 * there * along;
    hand.X_WT.q = normalized(from_rotation_vector(there * turn) * q);
    if (t < kIn) hand.V_WT.v = -kHandSpeed * from;
    if (t > kIn + kThere && t < kIn + kThere + kOut) hand.V_WT.v = kHandSpeed * from;
    if (there > 0 && there < kThere) hand.V_WT = {0.1 * along, turn};
    return hand;
  }
};

struct Felt {
  double most = 0, last = 0;  // of the force [N]
  double away = 0;            // of the proxy from the hand, at the end [m]
};

/// The force of a stroke with contacts that are `age` ticks old at most.
template <class Ask>
Felt feel(const Stroke& stroke, SoftSolver solver, int age, const Ask& ask) {
  SoftProxyModel model;
  model.solver = solver;
  BodyTick tick;
  tick.tool.radius = 0.03;
  tick.X_WO.resize(1);
  tick.V_WO.resize(1);
  tick.coupling = {2000, 5, 2, 0.005, 0, 0};
  SoftProxyState state;
  const auto set = std::make_unique<ContactSet>();
  Felt felt;
  const auto n =
      static_cast<int>((stroke.kIn + stroke.kThere + stroke.kOut + stroke.kRest) / kTick);
  for (int i = 0; i < n; ++i) {
    const ToolMotion hand = stroke.at(kTick * i);
    if (i % age == 0) {
      const bool at_hand = solver == SoftSolver::kDirect || !state.started;
      const Pose X_OT = at_hand ? hand.X_WT : state.proxy.X_WT;
      *set = {};
      ask(X_OT, *set);
      set->objects.resize(1);
      set->X_WT = X_OT;
    }
    tick.hand = hand;
    tick.contacts = set.get();
    const BodySolution solved = solve_soft_proxy(model, state, tick);
    felt.last = norm(solved.F_hand_W.f);
    felt.most = std::max(felt.most, felt.last);
    felt.away = norm(solved.proxy.X_WT.p - hand.X_WT.p);
  }
  return felt;
}

void add_judged(const Body& object, const Body& tool, const Pose& X_OT, ContactSet& set) {
  std::vector<TrianglePair> pairs(1 << 14);
  std::vector<PointPush> pushes(kPushesPerPair << 14);
  std::array<PushCluster, 16> clusters;
  PushOptions options;
  options.stiffness = kSpring;
  options.sharing = 1e9;
  const TriangleMesh mesh = tool.shape.mesh.view();
  options.clusters.radius = 0.125 * norm(mesh.upper - mesh.lower);
  ClusterMemory memory{};
  const ExactAnswer found = exact_contacts(object.shape.view(), tool.shape.view(), X_OT, options,
                                           memory, {pairs, pushes}, clusters);
  for (size_t i = 0; i < found.n_clusters; ++i) {
    set.contacts.push_back(contact_of(clusters[i], 0, {}, X_OT));
  }
  set.n_active = static_cast<uint32_t>(set.contacts.size());
}

}  // namespace

TEST_CASE("pieces: they push where triangles meet, as hard and the same way") {
  const bool has_levels = GENERATE(false, true);
  size_t n_pushing = 0, n_deep = 0;
  for (uint64_t seed = 0; seed < test::sweep(5); ++seed) {
    Random random(seed);
    const auto object = concave_body(random), tool = concave_body(random);
    Pieces pieces(*object, *tool, has_levels);
    for (int way = 0; way < 4; ++way) {
      const Vec3 from = random.direction();
      const Quat q = from_rotation_vector(random.uniform(0, 3) * random.direction());
      double distance = 0;
      if (!find_touch(*object, *tool, from, q, distance)) continue;
      // pressed in, and slid and turned at the speed of hands
      const Vec3 along = kHandSpeed * kTick * normalized(cross(from, random.direction()));
      const Vec3 turn = kHandTurns * kTick * random.direction();
      for (int tick = -4; tick <= 4; ++tick) {
        const Pose X_OT{(distance - random.uniform(-0.5e-3, 1.5e-3)) * from + 0.3 * tick * along,
                        normalized(from_rotation_vector(double(tick) * turn) * q)};
        const Vec3 F = pieces.force_at(X_OT);
        const Judged judged = judge(*object, *tool, X_OT);
        const double strength = norm(F);
        CAPTURE(has_levels, seed, way, tick, strength, norm(judged.alone), judged.sum);
        if (strength > 0) {
          ++n_pushing;
          CHECK(any_meet(*object, *tool, X_OT));
          CHECK(pieces.push_near_both(X_OT, has_levels ? 5e-3 : 1e-3));
          CHECK(strength <= 4 * norm(judged.alone) + 1e-9);
          // where the judge's springs cancel there is no one way, and levels of detail leave out
          // some
          const bool has_direction = norm(judged.alone) > kOfOneMind * judged.sum;
          const double cosine = dot(F, judged.alone) / (strength * norm(judged.alone));
          CHECK(cosine >= (has_direction ? 0 : has_levels ? -1.01 : -0.5));
        }
        const double depth = overlap(*object, *tool, X_OT);
        if (depth < kDeep || pieces.is_cut_short()) continue;
        ++n_deep;
        CAPTURE(depth, norm(judged.shared));
        CHECK(strength >= 0.5 * std::min(norm(judged.shared), kSpring * depth));
      }
    }
  }
  CHECK(n_pushing > 0);
  CHECK(n_deep > 0);
}

TEST_CASE("pieces: in a loop nothing is held where the hand has withdrawn, and nothing is kicked") {
  const auto solver =
      GENERATE(SoftSolver::kDirect, SoftSolver::kQuasiStatic, SoftSolver::kPenaltyDynamics);
  size_t strokes = 0;  // that were felt
  for (uint64_t seed = 0; seed < test::sweep(4); ++seed) {
    Random random(seed);
    const auto object = concave_body(random), tool = concave_body(random);
    const Stroke stroke(*object, *tool, random);
    if (!stroke.touches) continue;
    const int age = 1 + static_cast<int>(random.index(20));
    CAPTURE(seed, age);
    const Felt judged = feel(stroke, solver, age, [&](const Pose& X_OT, ContactSet& set) {
      add_judged(*object, *tool, X_OT, set);
    });
    for (const bool has_levels : {false, true}) {
      Pieces pieces(*object, *tool, has_levels);
      const Felt felt = feel(stroke, solver, age,
                             [&](const Pose& X_OT, ContactSet& set) { set = pieces.at(X_OT); });
      CAPTURE(has_levels, judged.most, felt.most, felt.last, felt.away);
      // contacts so old meet the judge by chance: else a spring that is pressed as deep as the hand
      CHECK(felt.most <= 4 * std::max(judged.most, kSpring * kStroke));
      // a tool with a mass swings out
      CHECK(felt.last <= (solver == SoftSolver::kPenaltyDynamics ? 0.05 : 0));
      CHECK(felt.away < 1e-4);
      strokes += felt.most > 0.5;
    }
  }
  CHECK(strokes > 0);
}

}  // namespace haptic
