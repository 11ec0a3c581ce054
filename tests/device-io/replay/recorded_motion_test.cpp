// SPDX-License-Identifier: GPL-3.0-or-later
// A recording at another speed, in part, again and again, and as the intention of a hand.
#include "device-io/replay/recorded_motion.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>

#include "device-io/replay/replay.h"
#include "proto/config/devices.h"
#include "proto/math/units.h"
#include "servo/safety/safety.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

Vec3 position(double t) {
  return {0.05 * std::sin(2 * t), 0.1 * t, 0.02};
}

HandCurve curve() {
  std::vector<DeviceState> samples;
  for (int i = 0; i <= 1000; ++i) {
    DeviceState sample{};
    sample.t_ns = 5 * kMs + i * kMs;
    const double t = 1e-3 * i;
    sample.X_BH = {position(t), from_rotation_vector({0, 0, t})};
    sample.flags = kDeviceFresh | kDeviceHomed;
    samples.push_back(sample);
  }
  return {samples, Resampling::kCubic, 0.02};
}

ReplayConfig part(double speed, double from, double to, bool loop) {
  ReplayConfig config;
  config.speed = speed, config.from = from, config.to = to, config.loop = loop ? 1 : 0;
  return config;
}

}  // namespace

TEST_CASE("replay: velocities and instants are those of the motion as it is played") {
  const double speed = GENERATE(0.1, 0.5, 1.0, 3.7);
  CAPTURE(speed);
  const RecordedMotion motion(curve(), part(speed, 0.2, 0.8, false));
  CHECK(motion.length_ns() == std::llround(0.6e9 / speed));
  for (int64_t t_ns = kMs; t_ns < motion.length_ns() - kMs; t_ns += 7 * kMs + 13) {
    const DeviceState state = motion.at(t_ns);
    const double t = 0.2 + 1e-9 * static_cast<double>(state.t_ns) * speed;
    CHECK(norm(state.X_BH.p - position(t)) < 2e-9);
    CHECK(state.V_BH.v.x == Approx(speed * 0.1 * std::cos(2 * t)).margin(2e-6 * speed));
    CHECK(state.V_BH.v.y == Approx(speed * 0.1));
    CHECK(state.V_BH.w.z == Approx(speed));
    CHECK(std::llabs(state.t_ns - t_ns) <= std::llround(kSnapNs / speed) + 1);
    CHECK((state.flags & kDeviceFresh) != 0);
  }
  const DeviceState end = motion.at(motion.length_ns() + 5 * kMs);
  CHECK((end.flags & (kDeviceEnded | kDeviceHeld)) == (kDeviceEnded | kDeviceHeld));
  CHECK(norm(end.V_BH.v) == 0);
  CHECK(norm(end.X_BH.p - position(0.8)) < 1e-9);
}

TEST_CASE("replay: a part that leaves nothing is refused") {
  CHECK_THROWS_WITH(RecordedMotion(curve(), part(1, 0.8, 0.3, false)),
                    Catch::Contains("leave nothing of a recording of 1.0"));
  CHECK_THROWS(RecordedMotion(curve(), part(1, 1.5, 0, false)));
}

TEST_CASE("replay: in a loop the pose never jumps, and nothing may be felt on the way back") {
  const RecordedMotion motion(curve(), part(2, 0.1, 0.9, true));
  const int64_t cycle_ns = motion.length_ns() + motion.return_ns();
  DeviceState last = motion.at(0);
  int returning = 0;
  for (int64_t t_ns = kMs; t_ns < 3 * cycle_ns; t_ns += kMs) {
    const DeviceState state = motion.at(t_ns);
    CAPTURE(t_ns);
    // no farther than the fastest of the motion and of the return in a millisecond
    REQUIRE(norm(state.X_BH.p - last.X_BH.p) < 1e-3 * std::max(2 * 0.15, kReturnSpeed) + 1e-9);
    REQUIRE(norm(to_rotation_vector(state.X_BH.q * conjugate(last.X_BH.q))) < 2.01e-3);
    REQUIRE((state.flags & kDeviceEnded) == 0);
    const bool is_back = t_ns % cycle_ns > motion.length_ns();
    REQUIRE(((state.flags & kDeviceHomed) == 0) == is_back);
    if (is_back) {
      ++returning;
      REQUIRE(norm(state.V_BH.v) <= kReturnSpeed * (1 + 1e-9));
      const DeviceState next = motion.at(t_ns + 1000), before = motion.at(t_ns - 1000);
      if (((next.flags | before.flags) & kDeviceHomed) == 0) {
        REQUIRE(norm((next.X_BH.p - before.X_BH.p) / 2e-6 - state.V_BH.v) < 1e-5);
      }
    }
    last = state;
  }
  CHECK(returning > 500);
  CHECK(norm(motion.at(cycle_ns).X_BH.p - position(0.1)) < 1e-9);
}

TEST_CASE("replay: as an intention the hand follows, and a force pushes it back by F/k") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/turning.csv";
  // a turn of 0.8 rad about an oblique axis, then rest
  const Vec3 axis = normalized(Vec3{1, -2, 2}), place{0.01, 0.02, 0.03};
  std::ofstream csv(path);
  csv.precision(17);
  csv << "t_s,x_m,y_m,z_m,qx,qy,qz,qw\n";
  for (int i = 0; i <= 300; ++i) {
    const double t = 0.01 * i;
    const Quat q = from_rotation_vector(0.8 * std::min(t, 1.0) * axis);
    csv << t << ",0.01,0.02,0.03," << q.x << ',' << q.y << ',' << q.z << ',' << q.w << '\n';
  }
  csv.close();
  DeviceConfig config{};
  config.kind = DeviceKind::kReplay;
  config.max_force = 20;
  config.max_torque = 0.2;
  assign(config.replay.path, path);
  config.replay.closed_loop = 1;
  SimulatedHandConfig& hand = config.hand;
  hand.coulomb_friction = hand.encoder_step = hand.angle_step = hand.rotational_friction = 0;
  const bool turns = GENERATE(true, false);
  hand.inertia = turns ? 1e-4 : 0;
  const std::unique_ptr<Device> device = open_device(config);
  CHECK_FALSE(device->caps().open_loop);
  CHECK(device->caps().max_torque == (turns ? 0.2 : 0));
  const Vec3 force{0, 3, 0}, torque{0, 0.1, 0};
  DeviceState state{};
  double lag = 0;
  for (int64_t t_ns = kMs; t_ns < 2900 * kMs; t_ns += kMs) {
    device->read({t_ns, t_ns}, state);
    device->write({force, t_ns > 1000 * kMs ? torque : Vec3{}});
    if (t_ns == 900 * kMs) lag = dot(axis, to_rotation_vector(state.X_BH.q)) - 0.8 * 0.899;
    if ((state.flags & (kDeviceEnded | kDeviceOpenLoop)) != 0) FAIL("flags at " << t_ns);
  }
  CHECK(norm(state.X_BH.p - (place + force / hand.hand_stiffness)) < 1e-6);
  // the wrist's spring and damper: b_R ω of the device is all that holds it back
  const double held_back = hand.rotational_damping * 0.8 / hand.hand_rotational_stiffness;
  CHECK(lag == Approx(turns ? -held_back : 0).margin(2e-4));
  const Vec3 twist = to_rotation_vector(state.X_BH.q * conjugate(from_rotation_vector(0.8 * axis)));
  CHECK(norm(twist - (turns ? torque / hand.hand_rotational_stiffness : Vec3{})) < 1e-5);
  for (int64_t t_ns = 2900 * kMs; t_ns < 3100 * kMs; t_ns += kMs) device->read({t_ns, t_ns}, state);
  CHECK((state.flags & kDeviceEnded) != 0);

  hand.hand_stiffness = 0;
  CHECK_THROWS_WITH(open_device(config), Catch::Contains("hand_stiffness"));
}

}  // namespace haptic
