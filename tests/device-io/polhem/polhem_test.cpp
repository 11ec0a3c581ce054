// SPDX-License-Identifier: GPL-3.0-or-later
// The kinematics of a Polhem. tests/device-io/driver tests what all drivers share.
#include "device-io/polhem/kinematics.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "device-io/polhem/linkage.h"
#include "tests/support/near.h"

using namespace haptic;
using haptic::test::IsNear;

namespace {

const Arm& kPolhem = polhem_arm();

}  // namespace

// Rows of the formulas in forsslund/hfabapi (cf00e97), evaluated in double: polhemKinematics and
// the configuration polhem_v3, getRot, computeMotorAmps without its compensation of gravity. Counts
// from home; place [m]; the handle's x and y axes; currents [A] of the force (1, 2, −3) N.
TEST_CASE("polhem: poses and currents are those of hfabapi", "[device-io]") {
  struct Row {
    MotorCounts counts;
    Vec3 p_B, x_B, y_B, amperes;
  };
  for (const Row& row : {
           Row{{-8312, 6022, -8557, -29, 128, -84},
               {-0.000021036, 0.000000000, 0.000001572},
               {0.9828060, -0.1459558, 0.1130896},
               {0.1787359, 0.9057057, -0.3843835},
               {1.118202, 0.909696, -0.304545}},
           Row{{-8312, 7117, -7407, 39, 92, 147},
               {0.049987841, 0.000000000, 0.000006462},
               {0.9750684, 0.1613185, 0.1523742},
               {-0.2216857, 0.7386312, 0.6366156},
               {1.391678, 1.017543, -0.473922}},
           Row{{-7803, 4324, -6994, -117, -144, 90},
               {-0.049996566, 0.020000610, 0.030006371},
               {0.1173130, 0.4422368, -0.8891931},
               {0.8032101, 0.4843101, 0.3468389},
               {0.790222, 0.585275, -0.303177}},
           Row{{-9440, 7115, -10276, -18, 132, -31},
               {0.000005592, -0.059979759, -0.039995749},
               {0.9289972, -0.3687498, -0.0314294},
               {0.3618211, 0.9228157, -0.1322747},
               {1.282349, 0.957863, -0.295665}},
           Row{{-7481, 7792, -9725, -52, 90, 126},
               {0.029996083, 0.050023833, -0.049990625},
               {0.9829346, -0.0057113, -0.1838665},
               {0.1552342, 0.5620426, 0.8124103},
               {1.145573, 1.323547, -0.192324}},
           Row{{-8985, 4264, -5100, 131, 93, 53},
               {-0.029980130, -0.029995881, 0.060001391},
               {0.9396967, 0.3389829, 0.0453948},
               {-0.3044671, 0.8896055, -0.3404437},
               {1.036386, 0.155648, -0.524372}},
           Row{{-8312, 8069, -12098, -73, -32, -73},
               {0.000002601, 0.000000000, -0.080008844},
               {0.3056265, 0.0053147, -0.9521367},
               {-0.0016523, 0.9999859, 0.0050514},
               {1.118331, 1.311351, 0.000063}},
       }) {
    CAPTURE(row.counts[1], row.counts[2]);
    const JointAngles angles = kPolhem.angles(row.counts);
    const Pose X_BH = kPolhem.pose(angles);
    CHECK_THAT(X_BH.p, IsNear(row.p_B, 2e-9));
    CHECK_THAT(rotate(X_BH.q, {1, 0, 0}), IsNear(row.x_B, 2e-7));
    CHECK_THAT(rotate(X_BH.q, {0, 1, 0}), IsNear(row.y_B, 2e-7));
    MotorEfforts amperes;
    REQUIRE(kPolhem.efforts(angles, X_BH, {{1, 2, -3}, {}}, amperes));
    CHECK_THAT((Vec3{amperes[0], amperes[1], amperes[2]}), IsNear(row.amperes, 2e-6));
    CHECK(amperes[3] == 0);
  }
  // at home it is folded: 222 mm before the middle of the workspace
  const Pose home = kPolhem.pose(kPolhem.angles({}));
  CHECK_THAT(home.p, IsNear({-0.222641279, 0.030859251, 0.037052267}, 2e-9));
}

TEST_CASE("polhem: a handle in line with the forearm has D = 0", "[device-io]") {
  JointAngles angles;
  for (const double straight : {0.0, std::numbers::pi}) {
    for (const double d : {0.0, 0.4, -2.0}) {
      const Pose X_BH = kPolhem.pose({0.1, 1.0, 2.0, d, -straight, 0.7});
      REQUIRE(kPolhem.solve(X_BH, angles));
      CHECK(angles[3] == 0);
      const Quat found = kPolhem.pose(angles).q;
      CHECK(norm(to_rotation_vector(found * conjugate(X_BH.q))) < 1e-7);
    }
  }
}

TEST_CASE("polhem: counts that no arm has give a finite pose and no current", "[device-io]") {
  std::mt19937 random(4);
  int open = 0;
  for (int i = 0; i < 20'000; ++i) {
    MotorCounts counts;
    for (int32_t& n : counts) n = static_cast<int32_t>(random() % 2'000'001) - 1'000'000;
    const JointAngles angles = kPolhem.angles(counts);
    const Pose X_BH = kPolhem.pose(angles);
    CHECK((is_finite(X_BH.p) && std::isfinite(norm(to_rotation_vector(X_BH.q)))));
    Mat3 J;
    if (linkage_jacobian(PolhemLinkage{}, {angles[0], angles[1], angles[2]}, J)) continue;
    MotorEfforts amperes;
    CHECK(kPolhem.efforts(angles, X_BH, {{1, 1, 1}, {}}, amperes));
    CHECK(amperes == MotorEfforts{});
    ++open;
  }
  CHECK(open > 1000);
}
