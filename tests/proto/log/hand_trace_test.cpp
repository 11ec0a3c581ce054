// SPDX-License-Identifier: GPL-3.0-or-later
// Impossible hand motion is refused on reading, before a device plays it.
#include "proto/log/hand_trace.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "clients/log/trace_writer.h"
#include "proto/log/trace.h"
#include "tests/support/hostile_text.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

std::string error_of(const std::string& path, double lever_arm = 0) {
  ReplayConfig config;
  assign(config.path, path);
  if (lever_arm != 0) assign(config.column, "lever_rad");
  config.lever_arm = lever_arm;
  config.axis_B = {1, 0, 0};
  return test::refusal([&] { load_hand_trace(config); });
}

/// Three ticks of a recording, with the second one changed.
std::string recording(const std::string& folder, const std::function<void(DeviceState&)>& change) {
  std::string path = folder + "/hand.mcap";
  TraceWriter trace(path, {});
  for (int i = 0; i < 3; ++i) {
    ServoFrame frame{};
    frame.tick = static_cast<uint64_t>(i);
    frame.device.t_ns = 1'000'000 * i;
    frame.device.flags = kDeviceFresh;
    if (i == 1) change(frame.device);
    trace.write(servo_topic(kFirstHand), frame, {});
  }
  trace.close();
  return path;
}

}  // namespace

TEST_CASE("hand trace: a recording with what is no motion is refused with its tick") {
  struct Wrong {
    std::function<void(DeviceState&)> change;
    std::string says;
  };
  const std::string not_finite = "tick 1: has a number that is not finite";
  const std::string not_unit = "tick 1: has an orientation that is no unit quaternion";
  const std::string too_far = ": time is more than a century from zero";
  const std::vector<Wrong> all{
      {[](DeviceState& s) { s.X_BH.p.y = kNan; }, not_finite},
      {[](DeviceState& s) { s.X_BH.q.w = kInfinite; }, not_finite},
      {[](DeviceState& s) { s.V_BH.v.x = -kInfinite; }, not_finite},
      {[](DeviceState& s) { s.V_BH.w.z = kNan; }, not_finite},
      {[](DeviceState& s) { s.grip = kNan; }, not_finite},
      {[](DeviceState& s) {
         s.X_BH.q = {0, 0, 0, 0};
       },
       not_unit},
      {[](DeviceState& s) {
         s.X_BH.q = {0, 0, 1e200, 0};
       },
       not_unit},
      {[](DeviceState& s) { s.X_BH.q.w = 1.00001; }, not_unit},
      {[](DeviceState& s) { s.t_ns = std::numeric_limits<int64_t>::max(); }, too_far},
      {[](DeviceState& s) { s.t_ns = std::numeric_limits<int64_t>::min(); }, too_far}};
  const test::TemporaryFolder folder;
  for (const Wrong& wrong : all) {
    CHECK_THAT(error_of(recording(folder.path(), wrong.change)), Catch::Contains(wrong.says));
  }
  CHECK(error_of(recording(folder.path(), [](DeviceState& s) {
          s.X_BH.q = {0, 0, 0.6, 0.8};
        })) == "");
}

TEST_CASE("hand trace: a table may say which buttons are down") {
  const test::TemporaryFolder folder;
  ReplayConfig config;
  assign(config.path, folder.path() + "/hand.csv");
  const std::string path(view(config.path));
  std::ofstream(path) << "t_s,x_m,y_m,z_m,buttons\n0,0,0,0,0\n1,0,0,0,5\n2,0,0,0,4294967295\n";
  const HandTrace trace = load_hand_trace(config);
  CHECK(trace.samples[0].buttons == 0);
  CHECK(trace.samples[1].buttons == 5);
  CHECK(trace.samples[2].buttons == 0xffffffff);
  std::ofstream(path) << "t_s,x_m,y_m,z_m,buttons\n0,0,0,0,0\n1,0,0,0,-1\n";
  CHECK_THAT(error_of(path), Catch::StartsWith(path + ":3: 'buttons' is one bit for each"));
}

TEST_CASE("hand trace: a table whose numbers leave the range of a motion is refused") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/hand.csv";
  std::ofstream(path) << "t_s,lever_rad\n0,0\n1,1e308\n";
  CHECK(error_of(path, 0.1).empty());
  CHECK_THAT(error_of(path, 10), Catch::StartsWith(path + ":3: has a number that is not finite"));
  std::ofstream(path) << "t_s,lever_rad\n0,0\n1e30,1\n";
  CHECK_THAT(error_of(path, 0.1), Catch::StartsWith(path + ":3: time is more than a century"));
  std::ofstream(path) << "t_s,lever_rad\n-1e300,0\n0,1\n";
  CHECK_THAT(error_of(path, 0.1), Catch::StartsWith(path + ":2: time is more than a century"));
}

}  // namespace haptic
