// SPDX-License-Identifier: GPL-3.0-or-later
// sim dies while the hand pushes a body with mass.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "proto/wire/scene_pose.h"
#include "tests/process/watcher.h"
#include "tests/support/near.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using namespace test;

constexpr double kStiffness = 500, kMaxForce = 6, kSlew = 500;  // [N/m], [N], [N/s]

/// A block of 20 kg that floats, and a hand that strokes it.
std::string write_session(const std::string& folder) {
  std::string path = folder + "/pushed.toml";
  std::ofstream(path) << R"([session]
name = "pushed"
realtime = false
[device]
kind = "simulated-hand"
max_force = "6 N"
[device.hand.intent]
hover_radius = "45 mm"
press_radius = "30 mm"
[coupling]
stiffness = "500 N/m"
[safety]
max_force = "6 N"
slew = "500 N/s"
[[object]]
name = "block"
primitive = "box"
extent = ["80 mm", "80 mm", "80 mm"]
[object.body]
mass = "20 kg"
)";
  return path;
}

/// Everything that servo and sim have published.
struct Published {
  std::vector<ServoFrame> servo;
  std::vector<SceneFrame> scenes;

  void drain(Watcher& watcher) {
    for (ServoFrame frame; watcher.servo.next(frame);) servo.push_back(frame);
    for (SceneFrame frame; watcher.sim.next(frame);) scenes.push_back(frame);
  }
  /// The first scene of the next sim; its seq goes on. End: it has published none yet.
  auto next_sim(int64_t killed_ns) const {
    return std::find_if(scenes.begin() + 1, scenes.end(), [=](const SceneFrame& scene) {
      return scene.t_ns > killed_ns && scene.t_ns - (&scene)[-1].t_ns > 5'000'000;
    });
  }
};

/// The process of that name which a parent has started; 0: none.
pid_t child_of(pid_t parent, const std::string& name) {
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::ifstream file(entry.path() / "stat");
    std::string pid, named, state, its_parent;
    // PID (NAME) STATE PARENT …
    file >> pid >> named >> state >> its_parent;
    if (named == "(" + name + ")" && state != "Z" && its_parent == std::to_string(parent)) {
      return std::stoi(pid);
    }
  }
  return 0;
}

bool is_mid_push(const Published& seen) {
  if (seen.servo.empty() || seen.scenes.empty()) return false;
  return norm(seen.servo.back().F_coupling_W.f) > 1 && norm(seen.scenes.back().V_WO[0].v) > 1e-3;
}

}  // namespace

TEST_CASE("pushed: sim is killed in mid-push, and the body is whole where it was extrapolated") {
  const int n_more = GENERATE(0, 3);  // kills of those that take over, 0, 20 and 40 ms old
  const TemporaryRuntimeFolder folder;
  const HapticdProcess hapticd({write_session(folder.path())}, folder.path());
  Watcher watcher("pushed");
  REQUIRE(watcher.wait_for_all());
  Published seen;
  REQUIRE(eventually([&] {
    seen.drain(watcher);
    return is_mid_push(seen);
  }));
  pid_t pid = writer_of(watcher.sim);
  REQUIRE(::kill(pid, SIGKILL) == 0);
  for (int k = 0; k < n_more; ++k) {
    const pid_t last_pid = pid;
    REQUIRE(eventually([&] {
      seen.drain(watcher);
      pid = child_of(hapticd.pid(), "haptic-sim");
      return pid != 0 && pid != last_pid;
    }));
    sleep_until(now_ns() + k * 20'000'000);
    REQUIRE(::kill(pid, SIGKILL) == 0);
  }
  const int64_t killed_ns = now_ns();
  // and what the hand feels for a while after it is back
  REQUIRE(eventually([&] {
    seen.drain(watcher);
    const auto back = seen.next_sim(killed_ns);
    return back != seen.scenes.end() && now_ns() - back->t_ns > kNsPerSecond / 2;
  }));
  INFO(hapticd.log());
  const auto next = seen.next_sim(killed_ns);
  const SceneFrame& last = next[-1];
  const double away = 1e-9 * static_cast<double>(next->t_ns - last.t_ns);
  CAPTURE(away);
  std::printf("sim: back %.0f ms after its last frame\n", 1e3 * away);  // stated: 200 ms
  CHECK(next->seq == last.seq + 1);
  // whoever read the last frame has seen the body there
  const auto used = std::find_if(seen.servo.begin(), seen.servo.end(),
                                 [&](const ServoFrame& f) { return f.t_ns == next->seen_t_ns[0]; });
  REQUIRE(used != seen.servo.end());
  const Pose expected = object_pose_at(last, 0, next->t_ns, push_of(*used));
  CHECK_THAT(next->X_WO[0].p, IsNear(expected.p, 1e-9));
  CHECK(norm(next->X_WO[0].p - last.X_WO[0].p) > 1e-6);
  // what was pushed while none moved it is counted, and nothing is given at once
  CHECK_THAT(next->V_WO[0].v, IsNear(last.V_WO[0].v, 1e-9));
  for (size_t k = 1; k < seen.servo.size(); ++k) {
    const ServoFrame &before = seen.servo[k - 1], &now = seen.servo[k];
    const double f = norm(now.F_device_B.f), grown = f - norm(before.F_device_B.f);
    const double dt = 1e-9 * static_cast<double>(now.t_ns - before.t_ns);
    CAPTURE(k, f, grown, dt);
    REQUIRE(f <= kMaxForce + 1e-9);
    // the rate limit, and the spring's own: hand and body move by less than 1 m/s against each
    // other
    REQUIRE(grown <= kSlew * dt + kStiffness * dt * 1.0 + 1e-9);
  }
}

}  // namespace haptic
