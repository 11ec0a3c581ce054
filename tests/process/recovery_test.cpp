// SPDX-License-Identifier: GPL-3.0-or-later
// hapticd is killed and started again: whoever watches is back by itself and says what it missed.
// sim is killed, and a body with mass goes on where its readers have carried it.
#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "clients/library/recorder.h"
#include "proto/log/trace.h"
#include "proto/wire/packing.h"
#include "proto/wire/scene_pose.h"
#include "tests/process/hapt_command.h"
#include "tests/process/watcher.h"
#include "tests/support/data.h"
#include "tests/support/near.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using namespace test;

std::string plane() {
  return test::from_source("configs/plane.toml");
}

/// A session that can be killed and started again.
struct Mortal {
  TemporaryRuntimeFolder folder;
  std::unique_ptr<HapticdProcess> hapticd = start();

  Mortal() { wait(); }
  std::unique_ptr<HapticdProcess> start() const {
    return std::make_unique<HapticdProcess>(
        std::vector<std::string>{plane(), "--session", "mortal"}, folder.path());
  }
  static void wait() {
    Watcher watcher("mortal");
    REQUIRE(watcher.wait_for_all());
  }
  void kill_and_start() {
    hapticd->send(SIGKILL);
    CHECK(hapticd->exit_code() == -SIGKILL);
    hapticd.reset();
    hapticd = start();
    wait();
  }
  void stop() const {
    hapticd->send(SIGTERM);
    CHECK(hapticd->exit_code() == 0);
  }
};

/// Counts how often the number goes back. It may stay: the last frame of a servo has the time of
/// the tick before it.
template <typename T, typename Number>
size_t steps_back(const std::vector<T>& records, Number number) {
  size_t n = 0;
  for (size_t i = 1; i < records.size(); ++i) n += number(records[i]) < number(records[i - 1]);
  return n;
}

constexpr size_t kEnough = 100;  // frames, to tell where a recording has its gap

/// Frames of the servo in a file that is still written.
size_t frames_in(const std::string& file) {
  return TraceReader(file).read(servo_topic(kFirstHand)).size();
}

/// Checks that every frame is of the one session or the other, and the gap where it is said to be.
void check_gap(const std::string& file) {
  const TraceReader trace(file);
  CHECK(trace.mcap().finished());
  const auto frames = trace.read(servo_topic(kFirstHand));
  CHECK(steps_back(frames, [](const auto& frame) { return frame.t_ns; }) == 0);
  std::vector<Event> gaps;
  for (const Event& event : trace.read(kEventTopic)) {
    if (event.code == static_cast<uint32_t>(EventCode::kSessionBack)) gaps.push_back(event);
  }
  // on a busy machine the killed one may still be reached, and hangs up
  REQUIRE(!gaps.empty());
  const Event& gap = gaps.back();
  CHECK(gap.numbers[0] > 0);
  size_t before = 0, after = 0;
  for (const ServoFrame& frame : frames) {
    (frame.t_ns < gap.t_ns - static_cast<int64_t>(1e9 * gap.numbers[0]) + 1'000'000 ? before
                                                                                    : after) += 1;
  }
  CHECK(before > kEnough);
  CHECK(after > kEnough);
  CHECK(frames[before - 1].tick == static_cast<uint64_t>(gap.numbers[1]));
}

/// A block of 20 kg that floats, and a hand that strokes it.
std::string write_pushed(const std::string& folder) {
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
  PackedRecords<SceneFrame> scenes;

  void drain(Watcher& watcher) {
    for (ServoFrame frame; watcher.servo.next(frame);) servo.push_back(frame);
    for (SceneFrame frame; watcher.sim.next(frame);) scenes.push_back(frame);
  }
  bool is_mid_push() const {
    if (servo.empty() || scenes.empty()) return false;
    return norm(servo.back().F_coupling_W.f) > 1 && norm(scenes.back().objects[0].V_WO.v) > 1e-3;
  }
  /// Place of the first scene of the next sim; scenes.size(): it has published none yet.
  size_t next_sim(int64_t killed_ns) const {
    const auto is_first = [&](size_t i) {
      const int64_t t_ns = scenes[i].t_ns;
      return t_ns > killed_ns && t_ns - scenes[i - 1].t_ns > 5'000'000;
    };
    size_t i = 1;
    while (i < scenes.size() && !is_first(i)) ++i;
    return i;
  }
};

}  // namespace

TEST_CASE(
    "recovery: hapt record and example 01 go on with the next hapticd, and end when it is told") {
  Mortal session;
  const std::string file = session.folder.path() + "/run.mcap";
  ProgramProcess recorder("hapt", {"record", "-o", file, "--session", "mortal"},
                          session.folder.path());
  ProgramProcess watch("01_watch", {"mortal"}, session.folder.path());
  REQUIRE(eventually([&] { return recorder.said("recording to "); }));
  REQUIRE(eventually([&] { return watch.said("tool "); }));
  REQUIRE(eventually([&] { return frames_in(file) > kEnough; }));
  session.kill_and_start();
  REQUIRE(eventually([&] { return recorder.said("hapticd is back after "); }));
  REQUIRE(eventually([&] {
    const std::string log = watch.log();
    const size_t at = log.find("hapticd is back after ");
    return at != log.npos && log.find("tool ", at) != log.npos;
  }));
  // frames of the session before may still be in the open chunk, a quarter of a second of them
  const size_t recorded = frames_in(file);
  REQUIRE(eventually([&] { return frames_in(file) > recorded + 5 * kEnough; }));
  // ended as it is told to, it is not waited for
  session.stop();
  CHECK(recorder.exit_code() == 0);
  CHECK(watch.exit_code() == 0);
  INFO(recorder.log());
  CHECK(recorder.said("hapticd is gone; "));
  CHECK(recorder.said("the session has ended"));
  check_gap(file);
}

TEST_CASE("recovery: hapt record waits no longer than it was told to record") {
  Mortal session;
  const std::string file = session.folder.path() + "/run.mcap";
  ProgramProcess recorder("hapt", {"record", "-o", file, "--session", "mortal", "--for", "3s"},
                          session.folder.path());
  REQUIRE(eventually([&] { return recorder.said("recording to "); }));
  session.hapticd->send(SIGKILL);
  CHECK(recorder.exit_code() == 0);
  CHECK(recorder.said("hapticd is gone; "));
  CHECK(TraceReader(file).mcap().finished());
}

TEST_CASE("pushed: sim is killed in mid-push, and the body is whole where it was extrapolated") {
  const TemporaryRuntimeFolder folder;
  const HapticdProcess hapticd({write_pushed(folder.path())}, folder.path());
  Watcher watcher("pushed");
  REQUIRE(watcher.wait_for_all());
  Published seen;
  REQUIRE(eventually([&] {
    seen.drain(watcher);
    return seen.is_mid_push();
  }));
  REQUIRE(::kill(writer_of(watcher.sim), SIGKILL) == 0);
  const int64_t killed_ns = now_ns();
  // the frame that the next sim has used may be read a moment later
  REQUIRE(eventually([&] {
    seen.drain(watcher);
    const size_t back = seen.next_sim(killed_ns);
    return back < seen.scenes.size() && now_ns() - seen.scenes[back].t_ns > kNsPerSecond / 10;
  }));
  INFO(hapticd.log());
  const size_t back = seen.next_sim(killed_ns);
  const SceneFrame next = seen.scenes[back], last = seen.scenes[back - 1];
  CAPTURE(next.t_ns - last.t_ns);
  CHECK(next.seq == last.seq + 1);
  // whoever read the last frame has seen the body there
  const int64_t used_ns = seen_of(next, 0, kFirstHand)->t_ns;
  const auto used = std::find_if(seen.servo.begin(), seen.servo.end(),
                                 [&](const ServoFrame& f) { return f.t_ns == used_ns; });
  REQUIRE(used != seen.servo.end());
  const Pose expected = object_pose_at(last, 0, next.t_ns, push_of(*used, kFirstHand));
  CHECK_THAT(next.objects[0].X_WO.p, IsNear(expected.p, 1e-9));
  CHECK(norm(next.objects[0].X_WO.p - last.objects[0].X_WO.p) > 1e-6);
  // what was pushed while none moved it is counted, and nothing is given at once
  CHECK_THAT(next.objects[0].V_WO.v, IsNear(last.objects[0].V_WO.v, 1e-9));
}

}  // namespace haptic
