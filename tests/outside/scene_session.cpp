// SPDX-License-Identifier: GPL-3.0-or-later
// The motion "nod" and the joint "rail", in sim's own step. Says what is wrong, and exits with 1.
#include <cmath>
#include <cstdio>

#include "proto/config/config.h"
#include "sim/joint/joint.h"
#include "sim/scene.h"

namespace {

using namespace haptic;

constexpr const char* kScene = R"(
[session]
name = "outside"
[device]
kind = "simulated-hand"
max_force = "10 N"
[[object]]
name = "plate"
primitive = "box"
extent = ["20 mm", "20 mm", "2 mm"]
[object.motion]
kind = "nod"
frequency = "1 Hz"
[[object]]
name = "carriage"
primitive = "box"
extent = ["10 mm", "10 mm", "10 mm"]
position = ["0 mm", "0 mm", "100 mm"]
[object.body]
mass = "50 g"
[[joint]]
kind = "rail"
object = "carriage"
axis = [0, 0, 1]
)";

int failures = 0;

void expect(bool holds, const char* what) {
  if (holds) return;
  std::printf("%s\n", what);
  failures = 1;
}

}  // namespace

int main() {
  const SessionConfig config = parse_config(kScene, "outside.toml");
  const ScriptedState half = scripted_state(config.objects[0], 3.141592653589793, 1);
  expect(std::fabs(half.X_WO.p.z - 2e-3) < 1e-12, "the plate is not 2 mm up after half a nod");
  const Pose X_W{config.objects[1].X_WO};
  const Joint joint = build_joint(config.joints[0], X_W, Pose{});
  const Pose moved = pose_on(joint, Pose{}, 0.01);
  expect(norm(moved.p - X_W.p) > 0.0099, "the carriage does not move along its rail");
  expect(std::fabs(moved.p.z - X_W.p.z) < 1e-12, "the carriage moves along its axis");
  const JointRows rows = joint_rows(joint, moved, Pose{}, 0.01);
  expect(std::fabs(rows.position - 0.01) < 1e-12, "the rail does not know where its carriage is");
  expect(rows.n_locks == 5, "a rail does not leave one freedom");
  return failures;
}
