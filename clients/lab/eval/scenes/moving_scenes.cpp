// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/scenes/moving_scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "clients/lab/eval/oracle/exact_cgal.h"
#include "clients/lab/support/shaking_hand.h"
#include "clients/lab/support/soups.h"
#include "contact/shape/parts/machine_parts.h"
#include "proto/math/motion_metric.h"
#include "proto/math/units.h"
#include "sim/scene.h"

namespace haptic {
namespace {

constexpr double kSampled = 1e-3;  // sampling interval of the free way [s]
constexpr int kMostDraws = 50;     // before the generator counts as broken

class SceneDice {
 public:
  explicit SceneDice(uint64_t seed) : bits_(seed) {}
  /// Unlike std::uniform_real_distribution, it gives equal numbers with every standard library.
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(bits_() >> 11) * 0x1p-53;
  }
  uint32_t below(uint32_t n) { return static_cast<uint32_t>(bits_() % n); }
  double sign() { return below(2) == 0 ? -1 : 1; }
  Vec3 direction() {
    const double z = uniform(-1, 1), angle = uniform(0, 2 * kPi), r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
  }
  uint64_t bits() { return bits_(); }

 private:
  std::mt19937_64 bits_;
};

/// A side with the same radius all over.
RadiusAt round_side(double radius) {
  return [radius](double, double) { return radius; };
}

/// True if a point is nearer to the z axis than that.
bool is_within(double radius, const Vec3& p) {
  return std::hypot(p.x, p.y) < radius;
}

/// A convex tool around its origin; inner_radius: distance of its surface from the origin [m].
struct Tool {
  Soup soup;
  double inner_radius = 0;
};

Tool draw_tool(SceneDice& dice) {
  const Vec3 extent{kMm * dice.uniform(16, 32), kMm * dice.uniform(16, 32),
                    kMm * dice.uniform(14, 32)};
  switch (dice.below(3)) {
    case 0:
      return {make_box({extent.x, extent.x, extent.x}), extent.x / 2};
    case 1:
      return {make_box({extent}), std::min({extent.x, extent.y, extent.z}) / 2};
    default: {
      const PartGrid grid{5 + dice.below(8), 1};
      const double r = extent.x / 2, half = extent.z / 2;
      return {make_turned(round_side(r), -half, half, grid),
              std::min(half, r * std::cos(kPi / grid.around))};
    }
  }
}

/// A plate from z = −thickness up to 0: flat, or bumpy with peaks at z = 0.
Soup draw_plate(SceneDice& dice, double half, double thickness) {
  if (dice.below(2) == 0) {
    return lowered(make_box({2 * half, 2 * half, thickness}), thickness / 2);
  }
  constexpr uint32_t n = 14;
  const double deepest = kMm * dice.uniform(0.2, 1.5);
  Soup soup;
  for (const bool is_upper : {true, false}) {
    for (uint32_t j = 0; j <= n; ++j) {
      for (uint32_t i = 0; i <= n; ++i) {
        const double z = is_upper ? -deepest * dice.uniform(0, 1) : -thickness;
        soup.vertices.push_back({half * (2.0 * i / n - 1), half * (2.0 * j / n - 1), z});
      }
    }
  }
  const auto upper = [](uint32_t i, uint32_t j) { return j * (n + 1) + i; };
  const auto lower = [&](uint32_t i, uint32_t j) { return upper(i, j) + (n + 1) * (n + 1); };
  const auto quad = [&](uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    soup.triangles.push_back({a, b, c});
    soup.triangles.push_back({a, c, d});
  };
  for (uint32_t j = 0; j < n; ++j) {
    for (uint32_t i = 0; i < n; ++i) {
      quad(upper(i, j), upper(i + 1, j), upper(i + 1, j + 1), upper(i, j + 1));
      quad(lower(i, j), lower(i, j + 1), lower(i + 1, j + 1), lower(i + 1, j));
    }
  }
  for (uint32_t k = 0; k < n; ++k) {
    quad(lower(k, 0), lower(k + 1, 0), upper(k + 1, 0), upper(k, 0));
    quad(lower(k + 1, n), lower(k, n), upper(k, n), upper(k + 1, n));
    quad(lower(0, k + 1), lower(0, k), upper(0, k), upper(0, k + 1));
    quad(lower(n, k), lower(n, k + 1), upper(n, k + 1), upper(n, k));
  }
  return soup;
}

/// A scene before it is placed in W.
struct Draft {
  MovingScene scene;
  std::vector<Soup> soups;
  Tool tool;

  /// Adds an object that oscillates along axis_O, `way` [m] ahead after a quarter period.
  void add(Soup soup, const Pose& X_SO, double way, double frequency, const Vec3& axis_O) {
    ObjectConfig move;
    move.X_WO = X_SO;
    move.motion = {way == 0 ? MotionKind::kStatic : MotionKind::kOscillate, 0,
                   way < 0 ? -axis_O : axis_O, std::fabs(way), frequency};
    scene.moves.push_back(move);
    soups.push_back(std::move(soup));
  }
};

/// Begins a draft with a tool and a clearance of this to 1 mm.
Draft draw_draft(SceneDice& dice, const std::string& kind, double least_clearance) {
  Draft draft{{}, {}, draw_tool(dice)};
  draft.scene.kind = kind;
  draft.scene.clearance = kMm * dice.uniform(least_clearance, 1);
  return draft;
}

struct Heights {
  double low = 0, high = 0;
};
Heights heights_of(const Soup& soup, const Quat& q) {
  Heights heights{std::numeric_limits<double>::infinity(),
                  -std::numeric_limits<double>::infinity()};
  for (const Vec3& v : soup.vertices) {
    const double z = rotate(q, v).z;
    heights.low = std::min(heights.low, z);
    heights.high = std::max(heights.high, z);
  }
  return heights;
}

/// Two plates that face each other: jaws, a pusher and a wall, or a slot. The free way turns the
/// tool level at once and keeps it in the middle.
Draft draw_plates(SceneDice& dice, uint32_t kind) {
  Draft draft = draw_draft(dice, std::array{"jaws", "pusher and wall", "slot"}[kind], 0.15);
  MovingScene& scene = draft.scene;
  const Soup tool = draft.tool.soup;
  const double tilt = dice.sign() * dice.uniform(0.15, 0.35), about = dice.uniform(0, 2 * kPi);
  const Quat spin = from_rotation_vector({0, 0, dice.uniform(0, 2 * kPi)});
  const Vec3 axis{std::cos(about), std::sin(about), 0};
  const auto tilted = [=](double share) {
    return normalized(from_rotation_vector(share * tilt * axis) * spin);
  };
  const double room = 2 * scene.clearance + kMm * dice.uniform(0.3, 1.5);
  const Heights first = heights_of(tool, tilted(1)), level = heights_of(tool, tilted(0));
  const double open = first.high - first.low + room;
  const double closes = std::max(open - (level.high - level.low + room), 0.0);
  const double frequency = dice.uniform(0.4, 1.2);
  const double carried = kind == 2 ? dice.sign() * kMm * dice.uniform(10, 25) : 0;
  const double lower_way = carried + (kind == 1 ? 0 : closes / 2);
  const double upper_way = carried - (kind == 1 ? closes : closes / 2);
  scene.seconds = 0.5 / frequency;
  const double half = 150 * kMm;
  const Vec3 up{0, 0, 1};
  const Quat upside_down = from_rotation_vector({kPi, 0, 0});
  draft.add(draw_plate(dice, half, kMm * dice.uniform(3, 10)), {{0, 0, -open / 2}, {}}, lower_way,
            frequency, up);
  draft.add(draw_plate(dice, half, kMm * dice.uniform(3, 10)), {{0, 0, open / 2}, upside_down},
            -upper_way, frequency, up);
  const double turned_in = 0.1 * scene.seconds;
  scene.way_W = [=](double t) {
    const Quat q = tilted(std::clamp(1 - t / turned_in, 0.0, 1.0));
    const double ahead = std::sin(2 * kPi * frequency * t);
    const double middle = 0.5 * (lower_way + upper_way) * ahead;
    const Heights now = heights_of(tool, q);
    return Pose{{0, 0, middle - 0.5 * (now.low + now.high)}, q};
  };
  scene.is_on_side = [](const Pose& X_WT, std::span<const Pose> X_WO) {
    return std::all_of(X_WO.begin(), X_WO.end(),
                       [&](const Pose& X) { return (inverse(X) * X_WT.p).z > 0; });
  };
  return draft;
}

/// A plate that turns about the axis of a drum and carries the tool along.
Draft draw_paddle(SceneDice& dice) {
  Draft draft = draw_draft(dice, "paddle", 0.3);
  MovingScene& scene = draft.scene;
  const double drum = kMm * dice.uniform(55, 75), half_height = 100 * kMm;
  const double thickness = kMm * dice.uniform(2, 8), turns = dice.sign() * dice.uniform(0.15, 0.5);
  scene.seconds = 0.8;
  const PartGrid grid{32, 2};
  draft.add(make_bored(round_side(drum + 10e-3), round_side(drum), -half_height, half_height, grid),
            {}, 0, 0, {0, 0, 1});
  const double tip = drum * std::cos(kPi / grid.around) - kMm;
  draft.add(make_box({2 * tip, thickness, 2 * half_height}), {}, 0, 0, {0, 0, 1});
  scene.moves.back().motion = {
      MotionKind::kSpin, 0, {0, 0, turns < 0 ? -1.0 : 1.0}, 0, std::fabs(turns)};
  const Quat held = normalized(from_rotation_vector(dice.uniform(0, 3) * dice.direction()));
  const Pose home{{0, 0.52 * drum, 0}, held};
  scene.way_W = [=](double t) {
    const Pose round{{}, from_rotation_vector({0, 0, 2 * kPi * turns * t})};
    return round * home;
  };
  scene.is_on_side = [drum](const Pose& X_WT, std::span<const Pose> X_WO) {
    return is_within(drum, inverse(X_WO[0]) * X_WT.p) && (inverse(X_WO[1]) * X_WT.p).y > 0;
  };
  return draft;
}

/// A block with a bore that moves sideways, and a piston in the bore that moves along it.
Draft draw_bore(SceneDice& dice) {
  Draft draft = draw_draft(dice, "bore and piston", 0.15);
  MovingScene& scene = draft.scene;
  double radius = 0;
  for (const Vec3& v : draft.tool.soup.vertices) radius = std::max(radius, std::hypot(v.x, v.y));
  const uint32_t around = 24;
  const double room = scene.clearance + kMm * dice.uniform(0.5, 3);
  const double bore = (radius + room) / std::cos(kPi / around);
  const double frequency = dice.uniform(0.4, 1.2), aside = dice.sign() * kMm * dice.uniform(5, 25);
  const double along = kMm * dice.uniform(5, 20);
  scene.seconds = 0.5 / frequency;
  const double half = 150 * kMm, piston = bore + std::fabs(aside) + 5e-3;
  draft.add(make_bored(round_side(bore + 12e-3), round_side(bore), -half, half, {around, 4}), {},
            aside, frequency, {1, 0, 0});
  const double foot = heights_of(draft.tool.soup, {}).low - 2 * scene.clearance - 0.2 * kMm;
  draft.add(make_turned(round_side(piston), -8e-3, 0, {16, 1}), {{0, 0, foot}, {}}, along,
            frequency, {0, 0, 1});
  scene.way_W = [=](double t) {
    const double ahead = std::sin(2 * kPi * frequency * t);
    return Pose{{aside * ahead, 0, along * ahead}, {}};
  };
  scene.is_on_side = [bore](const Pose& X_WT, std::span<const Pose> X_WO) {
    return is_within(bore, inverse(X_WO[0]) * X_WT.p) && (inverse(X_WO[1]) * X_WT.p).z > 0;
  };
  return draft;
}

/// A motion that leaves home.
std::function<Pose(double)> draw_hand(SceneDice& dice, const Pose& home, double seconds) {
  const double leave = dice.uniform(0.1, 0.6) * seconds;
  const Vec3 to = kMm * dice.uniform(10, 60) * dice.direction();
  const Vec3 turn = dice.uniform(0.2, 1.5) * dice.direction();
  const auto share = [leave](double t) { return std::clamp(t / leave, 0.0, 1.0); };
  switch (dice.below(5)) {
    case 0:
      return [=](double) { return home; };
    case 1:  // through whatever is there
      return [=](double t) { return Pose{home.p + share(t) * to, home.q}; };
    case 2:
      return [=](double t) { return moved(home, share(t) * Twist{to, turn}); };
    case 3:
      return [=](double t) { return moved(home, share(t) * Twist{{}, turn}); };
    default: {
      const double way = kMm * dice.uniform(3, 30), angle = dice.uniform(0.05, 0.5);
      const ShakingHand hand(home, {{way, way, way}, {angle, angle, angle}, {}}, dice.bits());
      return [=](double t) { return moved(home, share(t) * way_between(home, hand.at(t))); };
    }
  }
}

/// Builds the shapes and places the scene at a random pose in W.
MovingScene finish(Draft draft, uint64_t seed, SceneDice& dice) {
  MovingScene scene = std::move(draft.scene);
  scene.seed = seed;
  const Pose X_WS{0.05 * dice.direction(),
                  normalized(from_rotation_vector(dice.uniform(0, 3) * dice.direction()))};
  const auto shapes = std::make_shared<std::vector<MeshShapeData>>();
  for (Soup& soup : draft.soups) shapes->push_back(build_shape(std::move(soup)));
  const double thicker = 1 + scene.clearance / draft.tool.inner_radius;
  shapes->push_back(build_shape(scaled(draft.tool.soup, thicker)));
  shapes->push_back(build_shape(std::move(draft.tool.soup)));
  for (size_t i = 0; i + 2 < shapes->size(); ++i) scene.objects.push_back((*shapes)[i].view());
  scene.thick_tool = (*shapes)[shapes->size() - 2].view();
  scene.tool = shapes->back().view();
  scene.storage = shapes;
  for (ObjectConfig& move : scene.moves) move.X_WO = X_WS * move.X_WO;
  scene.way_W = [X_WS, way_S = scene.way_W](double t) { return X_WS * way_S(t); };
  scene.hand_W = draw_hand(dice, scene.way_W(0), scene.seconds);
  return scene;
}

/// Upper bound of the motion between two poses of any point within `reach` of the origin [m].
double travel(const Pose& from, const Pose& to, double reach) {
  return norm(to.p - from.p) + reach * norm(to_rotation_vector(to.q * conjugate(from.q)));
}

double reach_of(const MeshShape& shape) {
  double most = 0;
  for (const Vec3& v : shape.mesh.vertices) most = std::max(most, norm(v));
  return most;
}

}  // namespace

std::vector<Pose> object_poses(const MovingScene& scene, double t) {
  std::vector<Pose> poses;
  for (const ObjectConfig& move : scene.moves) {
    const double speed = phase_speed(move.motion);
    poses.push_back(scripted_state(move, speed * t, speed).X_WO);
  }
  return poses;
}

bool has_free_way(const MovingScene& scene) {
  const auto samples = static_cast<int>(std::ceil(scene.seconds / kSampled));
  Pose last_T = scene.way_W(0);
  std::vector<Pose> last_O = object_poses(scene, 0);
  for (int k = 0; k <= samples; ++k) {
    const double t = k * kSampled;
    const Pose X_WT = scene.way_W(t);
    const std::vector<Pose> X_WO = object_poses(scene, t);
    if (!scene.is_on_side(X_WT, X_WO)) return false;
    for (size_t i = 0; i < X_WO.size(); ++i) {
      const double nearer = travel(last_T, X_WT, reach_of(scene.tool)) +
                            travel(last_O[i], X_WO[i], reach_of(scene.objects[i]));
      // a pose in between is at most half of it away from one of the two samples
      if (nearer > 2 * scene.clearance) return false;
      const Pose X_OT = inverse(X_WO[i]) * X_WT;
      if (surfaces_meet_by_cgal(scene.objects[i].mesh, scene.thick_tool.mesh, X_OT)) return false;
    }
    last_T = X_WT;
    last_O = X_WO;
  }
  return true;
}

MovingScene make_moving_scene(uint64_t seed) {
  SceneDice dice(seed);
  const uint32_t kind = dice.below(5);
  for (int draw = 0; draw < kMostDraws; ++draw) {
    Draft draft = kind < 3    ? draw_plates(dice, kind)
                  : kind == 3 ? draw_paddle(dice)
                              : draw_bore(dice);
    const MovingScene scene = finish(std::move(draft), seed, dice);
    if (has_free_way(scene)) return scene;
  }
  throw std::logic_error("moving scene " + std::to_string(seed) +
                         ": no draw has a free way; its generator must be mended");
}

}  // namespace haptic
