// SPDX-License-Identifier: GPL-3.0-or-later
// Places of rest of a point: on solids made of cubes, with the hand in the planes of their faces to
// rounding, judged by the exact motion in the grid of cubes, which knows no triangle; at vertices
// of all kinds, judged by brute force over directions.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "contact/detect/point/point_proxy.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"
#include "tests/support/scenes.h"
#include "tests/support/tolerance.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kCell = 0.01;       // side of a cube [m]
constexpr double kFromExact = 1e-5;  // most that a rest is away from the exact minimiser [m]
constexpr double kNudge = 3e-7;      // of the starts around a rest: three times the stand-off [m]
constexpr double kHandStep = 2e-3;   // of the hand in 1 ms, at 2 m/s [m]
constexpr int kTicksAtRest = 3;      // after a stroke
constexpr double kNearer = 1e-9;     // nearer to the goal by less is the same place [m]

constexpr uint32_t kFirst = 1;  // vertex of the rim of a fan; 0 is the apex
constexpr int kTurns = 240, kTilts = 120;
// angle between two tested directions [rad]
constexpr double kGrid = 2 * std::numbers::pi / kTurns;

using Cell = std::array<int, 3>;

/// A solid made of the cubes of a grid; outside the grid is free.
struct Cubes {
  Cell size;
  std::vector<bool> full;

  explicit Cubes(const Cell& n, const std::function<bool(const Cell&)>& is_full) : size(n) {
    for (int z = 0; z < n[2]; ++z) {
      for (int y = 0; y < n[1]; ++y) {
        for (int x = 0; x < n[0]; ++x) full.push_back(is_full({x, y, z}));
      }
    }
  }
  bool operator()(const Cell& c) const {
    for (size_t i = 0; i < 3; ++i) {
      if (c[i] < 0 || c[i] >= size[i]) return false;
    }
    return full[static_cast<size_t>((c[2] * size[1] + c[1]) * size[0] + c[0])];
  }
};

/// Its surface: two triangles for every face between a full and a free cube; coplanar neighbours
/// stay apart.
Soup surface_of(const Cubes& cubes) {
  Soup soup;
  const Cell corners = {cubes.size[0] + 1, cubes.size[1] + 1, cubes.size[2] + 1};
  std::vector<uint32_t> known(static_cast<size_t>(corners[0] * corners[1] * corners[2]), kNoFace);
  const auto vertex = [&](const Cell& c) {
    uint32_t& index = known[static_cast<size_t>((c[2] * corners[1] + c[1]) * corners[0] + c[0])];
    if (index == kNoFace) {
      index = static_cast<uint32_t>(soup.vertices.size());
      soup.vertices.push_back({c[0] * kCell, c[1] * kCell, c[2] * kCell});
    }
    return index;
  };
  const auto add_face = [&](const Cell& cell, size_t axis, int side) {
    const size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    Cell a = cell;
    a[axis] += side;
    Cell b = a, c = a, d = a;
    b[u] += 1, c[u] += 1, c[v] += 1, d[v] += 1;
    std::array<uint32_t, 4> quad = {vertex(a), vertex(b), vertex(c), vertex(d)};
    if (side == 0) std::swap(quad[1], quad[3]);
    soup.triangles.push_back({quad[0], quad[1], quad[2]});
    soup.triangles.push_back({quad[0], quad[2], quad[3]});
  };
  for (int z = 0; z < cubes.size[2]; ++z) {
    for (int y = 0; y < cubes.size[1]; ++y) {
      for (int x = 0; x < cubes.size[0]; ++x) {
        for (size_t axis = 0; axis < 3 && cubes({x, y, z}); ++axis) {
          for (const int side : {0, 1}) {
            Cell beside = {x, y, z};
            beside[axis] += 2 * side - 1;
            if (!cubes(beside)) add_face({x, y, z}, axis, side);
          }
        }
      }
    }
  }
  return soup;
}

/// A point that knows in which cube it is: at a border the place alone would not say.
struct Walker {
  Vec3 x;
  Cell cell;
};

Cell cell_of(const Vec3& x) {
  return {static_cast<int>(std::floor(x.x / kCell)), static_cast<int>(std::floor(x.y / kCell)),
          static_cast<int>(std::floor(x.z / kCell))};
}

double& on_axis(Vec3& x, size_t axis) {
  return axis == 0 ? x.x : axis == 1 ? x.y : x.z;
}
double on_axis(const Vec3& x, size_t axis) {
  return x[static_cast<int>(axis)];
}

/// Moves along one axis; false where it meets a full cube, at which it stops.
bool walk_along(const Cubes& cubes, Walker& w, size_t axis, double to) {
  for (;;) {
    const bool up = to > on_axis(w.x, axis);
    const double border = (w.cell[axis] + (up ? 1 : 0)) * kCell;
    if (up ? to <= border : to >= border) break;
    Cell next = w.cell;
    next[axis] += up ? 1 : -1;
    if (cubes(next)) {
      on_axis(w.x, axis) = border;
      return false;
    }
    w.cell = next;
    on_axis(w.x, axis) = border;
  }
  on_axis(w.x, axis) = to;
  return true;
}

/// The border that a coordinate crosses first on its way to the goal.
double border_towards(const Walker& w, const Vec3& goal, size_t axis) {
  return (w.cell[axis] + (on_axis(goal, axis) > on_axis(w.x, axis) ? 1 : 0)) * kCell;
}

/// Moves within a cube towards the goal, all coordinates that are not held in one proportion, to
/// the first border. The axis across it; 3: it has reached the goal as far as it can.
size_t walk_to_border(Walker& w, const Vec3& goal, const std::array<bool, 3>& held) {
  size_t first = 3;
  double least = 1;
  for (size_t i = 0; i < 3; ++i) {
    const double border = border_towards(w, goal, i), x = on_axis(w.x, i), end = on_axis(goal, i);
    const bool crosses = end > x ? end > border : end < border;
    if (held[i] || !crosses) continue;
    const double share = (border - x) / (end - x);
    if (first == 3 || share < least) first = i, least = share;
  }
  const double at_border = first < 3 ? border_towards(w, goal, first) : 0;
  for (size_t i = 0; i < 3; ++i) {
    if (!held[i]) on_axis(w.x, i) += least * (on_axis(goal, i) - on_axis(w.x, i));
  }
  if (first < 3) on_axis(w.x, first) = at_border;
  return first;
}

/// Where a point ends that goes straight to the goal, and where a cube is in the way goes on along
/// its face. Faces are parallel to the axes, so a face holds one coordinate and leaves the others;
/// which are held is decided anew in each cube.
Vec3 exact_rest(const Cubes& cubes, Walker w, const Vec3& goal) {
  std::array<bool, 3> held{};
  for (;;) {
    const bool up_before[3] = {goal.x > w.x.x, goal.y > w.x.y, goal.z > w.x.z};
    const size_t axis = walk_to_border(w, goal, held);
    if (axis == 3) return w.x;
    Cell next = w.cell;
    next[axis] += up_before[axis] ? 1 : -1;
    held[axis] = cubes(next);
    if (held[axis]) continue;
    w.cell = next;
    held = {};
  }
}

/// The farthest exact end of motions that begin beside a rest, of those nearer to the goal: none
/// leads away from a minimum.
Vec3 leads_to(const Cubes& cubes, const Vec3& rest, const Vec3& goal) {
  Vec3 farthest = rest;
  for (size_t order = 0; order < 3; ++order) {
    for (int way = 0; way < 27; ++way) {
      const std::array<int, 3> signs = {way % 3 - 1, way / 3 % 3 - 1, way / 9 - 1};
      Walker w{rest, cell_of(rest)};
      bool goes = true;
      for (size_t i = 0; i < 3 && goes; ++i) {
        const size_t axis = (order + i) % 3;
        goes = walk_along(cubes, w, axis, on_axis(w.x, axis) + signs[axis] * kNudge);
      }
      const Vec3 end = exact_rest(cubes, w, goal);
      const bool nearer = norm(end - goal) < norm(rest - goal) - kNearer;
      if (nearer && norm(end - rest) > norm(farthest - rest)) farthest = end;
    }
  }
  return farthest;
}

/// 0: Menger's sponge of two levels; 1: stairs; 2: pillars of three heights; 3: a lattice of bars.
Cubes solid(int kind, Random& random) {
  if (kind == 0) {
    return Cubes({9, 9, 9}, [](Cell c) {
      for (int level = 0; level < 2; ++level) {
        const int middle = (c[0] % 3 == 1) + (c[1] % 3 == 1) + (c[2] % 3 == 1);
        if (middle >= 2) return false;
        for (int& i : c) i /= 3;
      }
      return true;
    });
  }
  if (kind == 1) return Cubes({8, 4, 8}, [](const Cell& c) { return c[2] <= c[0]; });
  if (kind == 2) {
    std::array<int, 64> heights;
    for (int& h : heights) h = 1 + static_cast<int>(random.index(3));
    // no two pillars touch in an edge alone
    for (int round = 0; round < 8; ++round) {
      for (int y = 0; y + 1 < 8; ++y) {
        for (int x = 0; x + 1 < 8; ++x) {
          int &a = heights[static_cast<size_t>(8 * y + x)],
              &b = heights[static_cast<size_t>(8 * y + x + 1)],
              &c = heights[static_cast<size_t>(8 * y + x + 8)],
              &d = heights[static_cast<size_t>(8 * y + x + 9)];
          if (std::min(a, d) > std::max(b, c)) b = std::min(a, d);
          if (std::min(b, c) > std::max(a, d)) a = std::min(b, c);
        }
      }
    }
    return Cubes({8, 8, 3}, [=](const Cell& c) {
      return c[2] < heights[static_cast<size_t>(8 * c[1] + c[0])];
    });
  }
  return Cubes({9, 9, 9}, [](const Cell& c) {
    return (c[0] % 4 == 0) + (c[1] % 4 == 0) + (c[2] % 4 == 0) >= 2;
  });
}

/// A place in or around the grid, each coordinate at a face to rounding, or anywhere.
Vec3 at_faces(const Cubes& cubes, Random& random) {
  // off a face by rounding, or by less than is felt
  const std::array<double, 8> rounding = {0, 1e-17, 1e-15, 1e-12, 1e-9, 2e-5, 5e-5, 2e-4};
  Vec3 p;
  for (size_t i = 0; i < 3; ++i) {
    const int n = cubes.size[i];
    on_axis(p, i) = random.uniform(-1.5, n + 1.5) * kCell;
    if (random.uniform(0, 1) > 0.6) continue;
    on_axis(p, i) = static_cast<double>(random.index(static_cast<size_t>(n + 1))) * kCell;
    on_axis(p, i) += rounding[random.index(rounding.size())] * (random.index(2) == 0 ? 1 : -1);
  }
  return p;
}

/// Facets around the origin with random heights, seen from +z.
Soup make_fan(Random& random) {
  const auto n = static_cast<uint32_t>(5 + random.index(5));
  Soup soup;
  soup.vertices = {{0, 0, 0}};
  for (uint32_t i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * (i + random.uniform(0, 0.5)) / n;
    const double height = random.uniform(-0.05, 0.15);
    soup.vertices.push_back({0.1 * std::cos(angle), 0.1 * std::sin(angle), height});
    soup.triangles.push_back({0, kFirst + i, kFirst + (i + 1) % n});
  }
  return soup;
}

/// Height of the fan over (x, y), by the two coordinates in the facet below.
double height_over(const Soup& fan, double x, double y) {
  for (const Triangle& t : fan.triangles) {
    const Vec3 &p = fan.vertices[t[1]], &q = fan.vertices[t[2]];
    const double area = p.x * q.y - p.y * q.x;
    const double a = (x * q.y - y * q.x) / area, b = (p.x * y - p.y * x) / area;
    if (a >= 0 && b >= 0) return a * p.z + b * q.z;
  }
  return 0;
}

/// Largest goal · d over unit directions above the fan; at least zero, because it may stay.
double furthest_above(const Soup& fan, const Vec3& goal) {
  double best = 0;
  for (int i = 0; i < kTurns; ++i) {
    const double c = std::cos(kGrid * i), s = std::sin(kGrid * i);
    const double slope = height_over(fan, c, s);
    for (int k = 0; k < kTilts; ++k) {
      const double tilt = std::numbers::pi * (k + 0.5) / kTilts - std::numbers::pi / 2;
      if (std::tan(tilt) < slope) continue;
      const Vec3 d{std::cos(tilt) * c, std::cos(tilt) * s, std::sin(tilt)};
      best = std::max(best, dot(goal, d));
    }
  }
  return best;
}

/// A goal that is not visible from the apex.
Vec3 hidden_goal(Random& random, const Soup& fan) {
  for (;;) {
    const Vec3 goal = 0.02 * random.direction();
    if (goal.z < height_over(fan, goal.x, goal.y)) return goal;
  }
}

}  // namespace

TEST_CASE("point proxy: on cubes it hangs at no edge, with the hand in the plane of a face",
          "[contact][property]") {
  const int kind = GENERATE(0, 1, 2, 3);
  const bool turned = GENERATE(false, true);
  Random random(60 + static_cast<uint64_t>(kind));
  const Cubes cubes = solid(kind, random);
  TestScene s;
  const Pose X_WO = turned ? random.pose(0.3) : Pose{};
  s.add(surface_of(cubes), X_WO);
  REQUIRE(s.shapes[0].mesh.closed);
  Vec3 hand = {-kCell, -kCell, -kCell};
  PointProxy proxy;
  REQUIRE(seed_proxy(s.scene, X_WO * hand, proxy) == 0);
  size_t in_contact = 0;
  const size_t n = sweep(1250);
  for (size_t stroke = 0; stroke < n; ++stroke) {
    const Vec3 goal = at_faces(cubes, random);
    const Vec3 way = goal - hand;
    const int ticks = static_cast<int>(norm(way) / kHandStep) + 1;
    ProxyMove move;
    for (int k = 1; k <= ticks + kTicksAtRest; ++k) {
      const Vec3 tool = k >= ticks ? goal : hand + (static_cast<double>(k) / ticks) * way;
      move = move_proxy(s.scene, X_WO * tool, proxy);
      REQUIRE((move.flags & kContactIterationLimit) == 0);
    }
    hand = goal;
    in_contact += move.n_active > 0;
    const Vec3 rest = inverse(X_WO) * proxy.g_W;
    const Vec3 end = leads_to(cubes, rest, goal);
    CAPTURE(kind, turned, stroke, rest, goal, end);
    REQUIRE_FALSE(cubes(cell_of(rest)));
    CHECK(norm(end - rest) <= kFromExact);
  }
  CHECK(in_contact > n / 4);
}

TEST_CASE("point proxy: at rest at a vertex where no direction leads nearer", "[contact][trap]") {
  Random random(3);
  int at_apex = 0;
  for (int trial = 0; trial < 1500; ++trial) {
    const Soup soup = make_fan(random);
    TestScene s;
    s.add(soup);
    s.scene.epsilon = 1e-10;
    PointProxy proxy;
    Vec3 start = 0.002 * random.direction();
    start.z = height_over(soup, start.x, start.y) + 1e-3;
    REQUIRE(seed_proxy(s.scene, start, proxy) == 0);
    const Vec3 tool = hidden_goal(random, soup);
    const ProxyMove move = move_proxy(s.scene, tool, proxy);
    CAPTURE(trial);
    CHECK((move.flags & kContactIterationLimit) == 0);
    CHECK(proxy.g_W.z > height_over(soup, proxy.g_W.x, proxy.g_W.y));
    if (norm(proxy.g_W) > 1e-6) continue;
    ++at_apex;
    CHECK(furthest_above(soup, tool) <= tol(kGrid * norm(tool)));
  }
  CHECK(at_apex > 20);
}
