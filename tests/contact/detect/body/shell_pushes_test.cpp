// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/body/shell_pushes.h"

#include "tests/support/meshes.h"
#include "tests/support/near.h"
#include "tests/support/torture_scale.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// A flat shell of n points with normals up, all at one height.
PointshellData flat_shell(size_t n) {
  PointshellData shell;
  for (size_t i = 0; i < n; ++i) {
    shell.x.push_back(2e-3f * static_cast<float>(i % 8));
    shell.y.push_back(2e-3f * static_cast<float>(i / 8));
    shell.z.push_back(0);
    shell.nx.push_back(0), shell.ny.push_back(0), shell.nz.push_back(1);
  }
  shell.radius = 0.03;
  return shell;
}

std::vector<PointPush> push_wall(const Voxmap& map, const Pointshell& shell, double height) {
  const Pose X_OT{{0, 0, height}, {}};
  std::vector<VoxelHit> hits(shell.x.size() + 8);
  hits.resize(scan_voxels(map, shell, shell_in_voxels(map, X_OT), 0,
                          static_cast<uint32_t>(shell.x.size()), ScanPath::kScalar, hits, 0));
  std::vector<PointPush> pushes(hits.size());
  pushes.resize(pushes_from_voxels(map, shell, X_OT, hits, {1000, 10}, pushes));
  return pushes;
}

}  // namespace

TEST_CASE("voxmap-pointshell: from ten points on 10·K_ff·d, continuous at ten", "[contact][trap]") {
  // all points at depth d on a flat wall, whose top voxel layer is surface (McNeely et al. 1999)
  const MeshShapeData block = build_shape(make_box({0.2, 0.2, 0.05}));
  const VoxmapData data = build_voxmap(block.mesh.view(), {1e-3, 2});
  const Voxmap map = data.view();
  // the middle of the topmost surface voxel over the block
  VoxelIndex top = map.index_of({0, 0, 0});
  while (map.at({top[0], top[1], top[2] + 1}) != Voxel::kProximity) ++top[2];
  REQUIRE(map.at(top) == Voxel::kSurface);
  const double d = 0.3e-3, height = map.centre_of(top).z - d;
  for (const size_t n : {1u, 5u, 9u, 10u, 11u, 40u, 64u}) {
    const PointshellData shell = flat_shell(n);
    const auto pushes = push_wall(map, shell.view(), height);
    REQUIRE(pushes.size() == n);
    const Wrench F = sum_pushes(pushes, {}).F0_O;
    CAPTURE(n);
    CHECK_THAT(F.f, IsNear({0, 0, 1000 * d * std::min<double>(static_cast<double>(n), 10)}, 1e-6));
    // the torque is divided too: the force acts at the centre of the points
    Vec3 middle;
    for (const PointPush& p : pushes) middle += (1.0 / static_cast<double>(n)) * p.point_O;
    CHECK_THAT(F.t, IsNear(cross(middle, F.f), 1e-7));
  }
}

TEST_CASE("distance-field penalty: what approaches is no harder than what touches",
          "[contact][trap]") {
  const PointshellData shell = flat_shell(64);
  std::vector<ShellTouch> touches;
  for (uint32_t i = 0; i < 64; ++i) touches.push_back({i, 1, i < 4 ? -1e-4 : 1e-4});
  std::vector<PointPush> pushes(touches.size());
  const size_t n = pushes_from_field(shell.view(), {}, touches, {1000, 10}, pushes);
  double touching = 0, near = 0;
  for (const PointPush& p : std::span(pushes).first(n)) {
    (p.depth > 0 ? touching : near) += p.stiffness;
  }
  CHECK(touching == Approx(4000));
  // 60 of 64 points that would divide 10·K_ff
  CHECK(near == Approx(10000 * 60.0 / 64));
}

TEST_CASE("voxmap-pointshell: the normal is the point's, not the voxel's", "[contact][trap]") {
  const MeshShapeData block = build_shape(make_box({0.2, 0.2, 0.05}));
  const VoxmapData data = build_voxmap(block.mesh.view(), {1e-3, 2});
  VoxelIndex top = data.view().index_of({0, 0, 0});
  while (data.view().at({top[0], top[1], top[2] + 1}) != Voxel::kProximity) ++top[2];
  PointshellData shell = flat_shell(1);
  const Vec3 tilted = normalized(Vec3{0.6, 0, 0.8});
  shell.nx[0] = static_cast<float>(tilted.x), shell.nz[0] = static_cast<float>(tilted.z);
  const auto pushes = push_wall(data.view(), shell.view(), data.view().centre_of(top).z - 0.2e-3);
  REQUIRE(pushes.size() == 1);
  CHECK_THAT(pushes[0].normal_O, IsNear(tilted, 1e-6));
}

TEST_CASE("voxmap-pointshell: interior pushes, proximity only brakes", "[contact]") {
  const MeshShapeData block = build_shape(make_box({0.2, 0.2, 0.05}));
  const VoxmapData data = build_voxmap(block.mesh.view(), {1e-3, 2});
  const PointshellData shell = flat_shell(4);
  const auto deep = push_wall(data.view(), shell.view(), 0);
  REQUIRE(deep.size() == 4);
  CHECK(deep[0].depth == Approx(0.5 * std::sqrt(3.0) * 1e-3));
  VoxelIndex ring = data.view().index_of({0, 0, 0});
  while (data.view().at(ring) != Voxel::kProximity) ++ring[2];
  const auto near = push_wall(data.view(), shell.view(), data.view().centre_of(ring).z);
  REQUIRE(near.size() == 4);
  CHECK(near[0].depth < 0);
  CHECK(sum_pushes(near, {}).F0_O == Wrench{});
  // 0.1 m/s down and 0.1 m/s sideways, two interpretations of the paper
  const Twist V{{0.1, 0, -0.1}, {}};
  const auto braking = [&near](const Twist& V_OT, Braking along) {
    return braking_matrix(near, V_OT, {}, 2, along) * V_OT;
  };
  const Wrench along_v = braking(V, Braking::kAlongVelocity);
  CHECK_THAT(along_v.f, IsNear((-4 * 2 / std::sqrt(2.0)) * V.v, 1e-9));
  const Wrench along_n = braking(V, Braking::kAlongNormal);
  CHECK_THAT(along_n.f, IsNear({0, 0, 4 * 2 * 0.1}, 1e-9));
  CHECK(braking({{0, 0, 0.1}, {}}, Braking::kAlongVelocity) == Wrench{});
}

TEST_CASE("voxmap-pointshell: a voxel's border is a step of at most K_ff·s a point",
          "[contact][trap]") {
  // artefacts of the method: one point through surface and interior in steps of 1 µm
  const double size = 1e-3;
  const MeshShapeData block = build_shape(make_icosphere(0.02, 3));
  const VoxmapData data = build_voxmap(block.mesh.view(), {size, 2});
  Random random(3);
  double largest = 0;
  for (size_t trial = 0; trial < trials(40); ++trial) {
    const Vec3 u = random.direction(), aside = 0.3 * random.direction();
    PointshellData shell = flat_shell(1);
    const Vec3 n = normalized(u + aside);
    shell.nx[0] = static_cast<float>(n.x), shell.ny[0] = static_cast<float>(n.y);
    shell.nz[0] = static_cast<float>(n.z);
    std::vector<VoxelHit> hits(9);
    std::vector<PointPush> pushes(9);
    double last = 0;
    for (int k = 0; k < 6000; ++k) {
      const Pose X_OT{(0.0245 - 1e-6 * k) * u, {}};
      const size_t m = scan_voxels(data.view(), shell.view(), shell_in_voxels(data.view(), X_OT), 0,
                                   1, ScanPath::kScalar, hits, 0);
      const size_t p =
          pushes_from_voxels(data.view(), shell.view(), X_OT, {hits.data(), m}, {1000, 10}, pushes);
      const double f = norm(sum_pushes({pushes.data(), p}, {}).F0_O.f);
      largest = std::max(largest, std::fabs(f - last));
      last = f;
    }
    // in the interior, the maximum
    REQUIRE(last == Approx(1000 * 0.5 * std::sqrt(3.0) * size));
  }
  CHECK(largest <= 1000 * size);
  CHECK(largest > 0.1 * 1000 * size);
}

TEST_CASE("distance-field penalty: continuous under steps of a micrometre", "[contact][trap]") {
  // |ΔF| ≤ k_c Σ |ΔP_i| over the touching points, at a fixed level and without division of
  // stiffness; 1e5 steps with HAPTIC_TORTURE_SCALE = 20
  const double radius = 0.05, stiffness = 100;
  const DistanceFieldData field =
      build_distance_field(-radius * Vec3{1, 1, 1}, radius * Vec3{1, 1, 1},
                           [&](const Vec3& p) { return norm(p) - radius; }, {2e-3, 8e-3, 8e-3});
  const PointshellData shell =
      build_pointshell(build_shape(make_icosphere(0.02, 2)).mesh.view(), 2e-3);
  std::vector<ShellVisit> visited(shell.nodes.size() + 1);
  std::vector<ShellTouch> touches(shell.x.size());
  std::vector<PointPush> pushes(shell.x.size());
  ShellCoherence coherence(shell.view());
  const ShellForce force{stiffness, 1e9, 0.5e-3};
  const auto steps = sweep(5000);
  // once over the ball and in by 4 mm, turning, whatever the number of steps
  const auto at = [&](double way) {
    const Vec3 u = normalized(Vec3{1, 3 * way, 2 * way});
    return Pose{(0.0705 - 0.4 * way) * u, from_rotation_vector({way, 5 * way, -2 * way})};
  };
  Wrench last;
  size_t n_last = 0;
  Pose X_last;
  double most = 0;
  for (size_t k = 0; k < steps; ++k) {
    // 1 µm per step; with few steps, short runs from many places
    const double start = 0.01 * static_cast<double>((7 * (k / 500) + 13) % 20) / 20;
    const Pose X_OT = at(start + 1.5e-6 * static_cast<double>(k % 500));
    const ShellAnswer answer =
        find_touches(field.view(), shell.view(), X_OT, {0.5e-3}, coherence, visited, touches);
    const size_t n =
        pushes_from_field(shell.view(), X_OT, {touches.data(), answer.n}, force, pushes);
    const Wrench F = sum_pushes({pushes.data(), n}, {}).F0_O;
    if (k % 500 > 0) {
      const double turn = norm(to_rotation_vector(X_OT.q * conjugate(X_last.q)));
      const double step = norm(X_OT.p - X_last.p) + 0.02 * turn;
      double deepest = 0;
      for (size_t i = 0; i < n; ++i) deepest = std::max(deepest, pushes[i].depth);
      // the gradient of the field is 1 ± 2 %, and the normals turn
      const double bound = stiffness * (1.02 * step + deepest * turn);
      REQUIRE(norm(F.f - last.f) <= bound * static_cast<double>(std::max(n, n_last)));
    }
    last = F, n_last = n, X_last = X_OT;
    most = std::max(most, norm(F.f));
  }
  CHECK(most > 0.1);
}

TEST_CASE("shell pushes: a touch that stands for several pushes as all of them", "[contact]") {
  const PointshellData shell = flat_shell(64);
  const std::vector<ShellTouch> touches{{5, 1, -1e-3}, {3, 15, 6e-3}, {20, 16, 1e-3}};
  std::vector<PointPush> pushes(touches.size());
  const size_t n = pushes_from_field(shell.view(), {}, touches, {100, 1e9}, pushes);
  REQUIRE(n == 3);
  for (size_t i = 0; i < n; ++i) {
    CHECK(pushes[i].count == touches[i].count);
    CHECK(pushes[i].stiffness == Approx(100.0 * touches[i].count));
    CHECK(pushes[i].depth == -touches[i].distance);
  }
}
