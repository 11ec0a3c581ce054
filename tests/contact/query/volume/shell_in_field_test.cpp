// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/volume/shell_in_field.h"

#include <algorithm>

#include "contact/query/volume/field_lanes.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"
#include "tests/support/torture_scale.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kRadius = 0.05;

/// A ball as the object, and a box as the tool.
struct ShellPair {
  DistanceFieldData field;
  PointshellData shell;
  std::vector<ShellVisit> visited;
  std::vector<ShellTouch> touches;

  ShellPair(double cell, double spacing)
      : field(build_distance_field(-kRadius * Vec3{1, 1, 1}, kRadius * Vec3{1, 1, 1},
                                   [](const Vec3& p) { return norm(p) - kRadius; },
                                   {cell, 4 * cell, 4 * cell})),
        shell(build_pointshell(build_shape(make_box({0.03, 0.05, 0.02})).mesh.view(), spacing)),
        visited(shell.nodes.size() + 1),
        touches(shell.x.size()) {}

  ShellAnswer ask(const Pose& X_OT, ShellCoherence* coherence = nullptr,
                  const ShellQuery& query = {}) {
    ShellCoherence nothing_known(shell.view());
    return find_touches(field.view(), shell.view(), X_OT, query,
                        coherence == nullptr ? nothing_known : *coherence, visited, touches);
  }
  /// Returns true if the other query gave the same answer.
  bool told_as(const ShellAnswer& own, const ShellPair& other, const ShellAnswer& others) const {
    const auto is_same = [](const ShellTouch& a, const ShellTouch& b) {
      return a.point == b.point && a.count == b.count && a.distance == b.distance;
    };
    return own.is_complete == others.is_complete && own.n == others.n &&
           std::equal(touches.begin(), touches.begin() + static_cast<std::ptrdiff_t>(own.n),
                      other.touches.begin(), is_same);
  }
  Vec3 point(uint32_t i) const {
    return {static_cast<double>(shell.x[i]), static_cast<double>(shell.y[i]),
            static_cast<double>(shell.z[i])};
  }
};

/// A tool that comes near the ball and slides over it.
Pose slide(double t, double height) {
  const Quat turn = from_rotation_vector({0.3 * t, 0.2 * std::sin(t), 0.1});
  return {rotate(from_rotation_vector({0, 0, t}), {kRadius + height, 0, 0}), turn};
}

}  // namespace

TEST_CASE("shell in field: pruning never changes the result", "[contact][trap]") {
  ShellPair pair(2e-3, 1.5e-3);
  Random random(1);
  size_t touching = 0;
  for (size_t k = 0; k < trials(300); ++k) {
    const Pose X_OT = random.pose(0.06);
    const double reach = k % 2 == 0 ? 0 : 1e-3;
    const ShellAnswer answer = pair.ask(X_OT, nullptr, {reach, ~0u});
    REQUIRE(answer.is_complete);
    size_t next = 0;
    for (uint32_t i = 0; i < pair.shell.x.size(); ++i) {
      const double d = sample_field(pair.field.view(), X_OT * pair.point(i)).distance;
      if (!(d < reach)) continue;
      REQUIRE(next < answer.n);
      REQUIRE(pair.touches[next].point == i);
      REQUIRE(pair.touches[next].count == 1);
      REQUIRE(pair.touches[next++].distance == d);
    }
    REQUIRE(next == answer.n);
    touching += answer.n;
  }
  CHECK(touching > 1000);
}

TEST_CASE("shell in field: of a patch that approaches the nearest point stands for all",
          "[contact][trap]") {
  ShellPair pair(2e-3, 1e-3);
  const Pointshell shell = pair.shell.view();
  const uint32_t first = shell.levels[shell.levels.size() - 4],
                 end = shell.levels[shell.levels.size() - 3];
  size_t touching = 0, approaching = 0, both = 0;
  for (size_t k = 0; k < trials(300); ++k) {
    const Pose X_OT = slide(1e-3 * static_cast<double>(k), 0.0155);
    const ShellQuery query{2e-3, ~0u, 0.5e-3};
    const ShellAnswer answer = pair.ask(X_OT, nullptr, query);
    // each patch by itself, point by point
    std::vector<ShellTouch> expected;
    for (const ShellNode& patch : shell.nodes.subspan(first, end - first)) {
      ShellTouch nearest{0, patch.count, query.reach};
      const size_t before = expected.size();
      for (uint32_t i = patch.first; i < patch.first + patch.count; ++i) {
        const double d = sample_field(pair.field.view(), X_OT * pair.point(i)).distance;
        if (d < query.touch) {
          expected.push_back({i, 1, d});
        } else if (d < nearest.distance) {
          nearest.point = i, nearest.distance = d;
        }
      }
      touching += expected.size() - before;
      if (!(nearest.distance < query.reach)) continue;
      both += expected.size() > before ? 1 : 0;
      expected.push_back(nearest);
      ++approaching;
    }
    REQUIRE(answer.is_complete);
    REQUIRE(answer.n == expected.size());
    for (size_t i = 0; i < answer.n; ++i) {
      REQUIRE(pair.touches[i].point == expected[i].point);
      REQUIRE(pair.touches[i].count == expected[i].count);
      REQUIRE(pair.touches[i].distance == expected[i].distance);
    }
  }
  CHECK(touching > 0);
  CHECK(approaching > 0);
  CHECK(both > 0);
}

TEST_CASE("shell in field: temporal coherence is bit-identical, and asks ten times less",
          "[contact][trap]") {
  ShellPair with(1e-3, 0.7e-3), without(1e-3, 0.7e-3);
  ShellCoherence coherence(with.shell.view());
  uint64_t asked_with = 0, asked_without = 0;
  size_t touching = 0;
  for (size_t k = 0; k < trials(20000) / 10; ++k) {
    // in contact and out of it
    const double t = 1e-3 * static_cast<double>(k);
    const Pose X_OT = slide(0.5 * t, 0.0162 + 2e-3 * std::sin(3 * t));
    const ShellAnswer a = with.ask(X_OT, &coherence), b = without.ask(X_OT);
    REQUIRE(with.told_as(a, without, b));
    touching += a.n;
  }
  if (kSlowdown == 1) CHECK(touching > 0);
  coherence.forget();
  for (size_t k = 0; k < 2000; ++k) {
    // a near miss: a few millimetres off at 0.05 m/s
    const Pose X_OT = slide(0.5e-3 * static_cast<double>(k), 0.0375);
    asked_with += with.ask(X_OT, &coherence).tested;
    asked_without += without.ask(X_OT).tested;
  }
  CAPTURE(asked_with, asked_without);
  CHECK(asked_with * 10 <= asked_without);
}

TEST_CASE("shell in field: coherence is bit-identical on a random walk and for any reach",
          "[contact][trap]") {
  // random frames, 1e5 with HAPTIC_TORTURE_SCALE = 40
  ShellPair with(1.5e-3, 1.2e-3), without(1.5e-3, 1.2e-3);
  ShellCoherence coherence(with.shell.view());
  Random random(8);
  Pose X_OT = slide(0, 0.02);
  size_t touching = 0;
  const auto frames = sweep(2500);
  double reach = 0;
  for (size_t k = 0; k < frames; ++k) {
    // at most a third of a millimetre per frame; drawn back if something touches
    const Vec3 home = (kRadius + 0.014) * normalized(X_OT.p);
    X_OT.p += random.uniform(0, 0.3e-3) * random.direction() + 0.02 * (home - X_OT.p);
    X_OT.q =
        normalized(from_rotation_vector(random.uniform(0, 0.02) * random.direction()) * X_OT.q);
    if (k % 50 == 0) reach = k % 100 == 0 ? 0 : 5.5e-3;
    // sometimes all points within reach, sometimes the nearest of each patch
    const ShellQuery query{reach, ~0u, k / 150 % 2 == 0 ? reach : 0.2e-3};
    const ShellAnswer a = with.ask(X_OT, &coherence, query);
    const ShellAnswer b = without.ask(X_OT, nullptr, query);
    REQUIRE(with.told_as(a, without, b));
    touching += a.n;
  }
  CHECK(touching > frames);
}

TEST_CASE("shell in field: coherence is bit-identical in a narrow gap, whatever the reach",
          "[contact][trap]") {
  // points closer to the surface than a cell, cells coarser than the gap
  ShellPair with(3e-3, 0.7e-3), without(3e-3, 0.7e-3);
  ShellCoherence coherence(with.shell.view());
  uint64_t asked_with = 0, asked_without = 0, told = 0;
  const double touch = GENERATE(0.0, 1e-4);
  for (size_t k = 0; k < trials(2000); ++k) {
    const double t = 1e-4 * static_cast<double>(k);
    const Pose X_OT = slide(t, 0.0155 + 3e-4 * std::sin(200 * t));
    const ShellQuery query{2e-4 * (1 + std::sin(37 * t)), ~0u, k % 500 < 250 ? 1e-3 : touch};
    const ShellAnswer a = with.ask(X_OT, &coherence, query), b = without.ask(X_OT, nullptr, query);
    REQUIRE(with.told_as(a, without, b));
    told += a.n;
    asked_with += a.tested;
    asked_without += b.tested;
  }
  // with few trials it ends before it touches
  if (kSlowdown == 1) CHECK(told > 0);
  CHECK(asked_with * 2 < asked_without);
}

TEST_CASE("shell in field: lanes tell to the bit what one point after the other does",
          "[contact][trap]") {
  ShellPair pair(2e-3, 1.5e-3);
  const DistanceField field = pair.field.view();
  Random random(1);
  for (size_t k = 0; k < trials(2000); ++k) {
    const Pose X_OT = random.pose(0.02);
    FieldBatch lanes;
    lanes.n = random.index(FieldBatch::kRoom + 1);
    for (size_t i = 0; i < lanes.n; ++i) {
      // near the surface, far from it, beyond the field, nowhere
      const double r = random.uniform(0, 1) < 0.1 ? 0.2 : random.uniform(0.8, 1.2) * kRadius;
      const Vec3 p = inverse(X_OT) * (r * random.direction());
      lanes.x[i] = static_cast<float>(random.uniform(0, 1) < 0.01 ? std::nan("") : p.x);
      lanes.y[i] = static_cast<float>(p.y), lanes.z[i] = static_cast<float>(p.z);
    }
    FieldBatch one = lanes;
    look_up(field, X_OT, lanes);
    look_up_one_by_one(field, X_OT, one);
    for (size_t i = 0; i < lanes.n; ++i) {
      REQUIRE(lanes.distance[i] == one.distance[i]);
      REQUIRE(lanes.found(i).is_near == one.found(i).is_near);
      if (std::isnan(lanes.x[i])) continue;
      const Vec3 p_T{static_cast<double>(lanes.x[i]), static_cast<double>(lanes.y[i]),
                     static_cast<double>(lanes.z[i])};
      const FieldSample sample = sample_field(field, X_OT * p_T);
      REQUIRE(sample.distance == one.distance[i]);
      REQUIRE(sample.is_near == one.found(i).is_near);
    }
  }
}

TEST_CASE("shell in field: out of budget coarser points stand for the rest", "[contact]") {
  ShellPair pair(2e-3, 1e-3);
  const Pose X_OT = slide(0.4, 0.010);
  const ShellAnswer whole = pair.ask(X_OT);
  REQUIRE(whole.is_complete);
  size_t level_before = 0;
  for (const uint32_t budget : {16u, 64u, 256u, 1024u, whole.tested}) {
    const ShellAnswer part = pair.ask(X_OT, nullptr, {0, budget});
    CAPTURE(budget, part.tested, part.level);
    CHECK(part.tested <= budget);
    uint32_t covered = 0;
    for (size_t i = 0; i < part.n; ++i) covered += pair.touches[i].count;
    if (part.is_complete) CHECK(covered == whole.n);
    // more points never give a smaller answer
    CHECK(part.is_complete == (budget == whole.tested));
    CHECK(part.level >= level_before);
    level_before = part.level;
  }
}

TEST_CASE("shell in field: no point over the budget, with coherence either", "[contact][trap]") {
  ShellPair pair(2e-3, 1e-3);
  ShellCoherence coherence(pair.shell.view());
  size_t cut_short = 0;
  for (size_t k = 0; k < trials(2000); ++k) {
    // the budget varies: points that were not tested for lack of budget must not count as free
    const uint32_t budget = k % 3 == 0 ? ~0u : 16 + static_cast<uint32_t>(k % 100);
    const Pose X_OT = slide(1e-3 * static_cast<double>(k), 0.0355);
    const ShellAnswer a = pair.ask(X_OT, &coherence, {1e-3, budget});
    REQUIRE(a.tested <= budget);
    cut_short += a.is_complete ? 0 : 1;
    for (size_t i = 0; i < a.n; ++i) REQUIRE(pair.touches[i].distance < 1e-3);
    if (budget == ~0u) REQUIRE(a.n == pair.ask(X_OT, nullptr, {1e-3, ~0u}).n);
  }
  // with few trials there is little to cut off
  if (kSlowdown == 1) CHECK(cut_short > 0);
}

TEST_CASE("shell in field: a budget for what is near becomes enough though all is unknown at first",
          "[contact][trap]") {
  ShellPair pair(2e-3, 0.7e-3), other(2e-3, 0.7e-3);
  ShellCoherence coherence(pair.shell.view());
  const auto at = [](size_t k) { return slide(1e-4 * static_cast<double>(k), 0.0152); };
  // number of lookups if every point must be tested
  const ShellQuery whole{1e-3, ~0u, 0};
  uint32_t first = 0, later = 0;
  for (size_t k = 0; k < 50; ++k) {
    const uint32_t tested = pair.ask(at(k), &coherence, whole).tested;
    if (k == 0) first = tested;
    later = std::max(k < 10 ? 0 : later, tested);
  }
  REQUIRE(later * 3 < first);
  coherence.forget();
  const ShellQuery query{1e-3, 2 * later, 0};
  size_t coarse = 0;
  for (size_t k = 0; k < 50; ++k) {
    const ShellAnswer a = pair.ask(at(k), &coherence, query);
    REQUIRE(a.tested <= query.budget);
    if (k > 40) REQUIRE(a.is_complete);
    coarse += a.is_complete ? 0 : 1;
    if (!a.is_complete) continue;
    REQUIRE(pair.told_as(a, other, other.ask(at(k), nullptr, whole)));
  }
  CHECK(coarse > 0);
}

TEST_CASE("shell in field: whatever the budget, what touches is told where points are",
          "[contact][trap]") {
  // every point tested, then pressed in at once: many nearest points begin to touch
  ShellPair pair(2e-3, 1e-3);
  const ShellQuery whole{1e-3, ~0u, 0};
  size_t short_ones = 0, touching = 0;
  for (size_t k = 0; k < trials(300); ++k) {
    const double height = 0.0154 - 4e-5 * static_cast<double>(k % 10);
    const auto at = [&](double depth) { return slide(0.02 + 4 * depth, height - depth); };
    ShellCoherence known(pair.shell.view());
    for (int i = 0; i < 3; ++i) pair.ask(at(1e-6 * i), &known, whole);
    const Pose X_OT = at(0.02e-3);
    ShellCoherence copy = known;
    const uint32_t enough = pair.ask(X_OT, &copy, whole).tested;
    // from a sufficient budget to a little less than the first query needs
    const uint32_t budget = enough - std::min(enough, static_cast<uint32_t>(k / 10));
    const ShellAnswer a = pair.ask(X_OT, &known, {1e-3, budget, 0});
    REQUIRE(a.tested <= budget);
    short_ones += a.is_complete ? 0 : 1;
    if (a.level < pair.shell.levels.size() - 2) continue;
    size_t told = 0, expected = 0;
    for (size_t i = 0; i < a.n; ++i) told += pair.touches[i].distance < 0 ? 1 : 0;
    for (uint32_t i = 0; i < pair.shell.x.size(); ++i) {
      expected += sample_field(pair.field.view(), X_OT * pair.point(i)).distance < 0 ? 1 : 0;
    }
    REQUIRE(told == expected);
    touching += told;
  }
  CHECK(short_ones > 0);
  CHECK(touching > 0);
}

TEST_CASE("shell in field: after a pose out of this world all is as before", "[contact][trap]") {
  ShellPair with(2e-3, 1e-3), without(2e-3, 1e-3);
  ShellCoherence coherence(with.shell.view());
  const double far = GENERATE(1e200, 1e9, std::numeric_limits<double>::infinity());
  const ShellQuery query{1e-3, ~0u, 0};
  with.ask(slide(0, 0.018), &coherence, query);
  CHECK(with.ask({{far, 0, 0}, {}}, &coherence, query).is_complete == std::isfinite(far));
  size_t told = 0;
  for (size_t k = 0; k < 2000; ++k) {
    const Pose X_OT = slide(0, 0.0161 - 1e-7 * static_cast<double>(k));
    const ShellAnswer a = with.ask(X_OT, &coherence, query);
    if (k % 100 > 0) continue;
    REQUIRE(with.told_as(a, without, without.ask(X_OT, nullptr, query)));
    told += a.n;
  }
  CHECK(told > 0);
}

TEST_CASE("shell in field: a shell of a few points is searched as well", "[contact]") {
  const double spacing = GENERATE(0.2, 0.05, 0.02);
  ShellPair with(2e-3, spacing), without(2e-3, spacing);
  CAPTURE(with.shell.x.size(), with.shell.levels.size());
  ShellCoherence coherence(with.shell.view());
  Random random(1);
  size_t told = 0;
  for (size_t k = 0; k < trials(500); ++k) {
    const Pose X_OT = random.pose(0.05);
    const ShellQuery query{5e-3, ~0u, k % 2 == 0 ? 0 : 5e-3};
    const ShellAnswer a = with.ask(X_OT, &coherence, query);
    REQUIRE(with.told_as(a, without, without.ask(X_OT, nullptr, query)));
    told += a.n;
    with.ask(X_OT, &coherence, {5e-3, 1, 0});
  }
  CHECK(told > 0);
}

TEST_CASE("shell in field: what there was no room for is told by the next query",
          "[contact][trap]") {
  ShellPair with(2e-3, 1e-3), without(2e-3, 1e-3);
  ShellCoherence coherence(with.shell.view());
  const ShellQuery query{2e-3, ~0u, 0};
  const std::span<ShellTouch> few(with.touches.data(), 5);
  size_t short_ones = 0, told = 0;
  for (size_t k = 0; k < trials(1000); ++k) {
    const Pose X_OT = slide(1e-4 * static_cast<double>(k), 0.0156);
    if (k % 3 > 0) {
      const ShellAnswer a = find_touches(with.field.view(), with.shell.view(), X_OT, query,
                                         coherence, with.visited, few);
      REQUIRE(a.n <= few.size());
      short_ones += a.is_complete ? 0 : 1;
      continue;
    }
    const ShellAnswer a = with.ask(X_OT, &coherence, query);
    REQUIRE(with.told_as(a, without, without.ask(X_OT, nullptr, query)));
    told += a.n;
  }
  CHECK(short_ones > 0);
  CHECK(told > 0);
}
