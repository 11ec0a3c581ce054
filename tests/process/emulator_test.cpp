// SPDX-License-Identifier: GPL-3.0-or-later
// Forces that a hand receives from a real session over a serial node. Every force is read from the
// log of the emulated device, a separate process with its own clock; none from the server's frames.
#include <algorithm>
#include <catch2/catch.hpp>
#include <sstream>

#include "proto/ipc/control_socket.h"
#include "proto/math/units.h"
#include "tests/process/emulator_process.h"
#include "tests/process/network.h"
#include "tests/process/watcher.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tip.h"
#include "tests/support/tolerance.h"

namespace haptic {
namespace {

using namespace test;

using Records = std::vector<EmulatorRecord>;

constexpr double kStiffness = 500;  // [N/m]
constexpr double kMaxDamping = 2;   // default of the passivity controller [N·s/m]
// 0.5 mA in each of three motors, as a force at the tip, in all poses of these tests
constexpr double kCurrentStep = 5e-3;  // [N]

/// The hand hovers 2 mm over the plane z = 0, aims 10 mm below it, rests there, lifts.
std::vector<std::string> pressing(const std::string& hand = "typical") {
  std::istringstream all("--hand|" + hand +
                         "|--centre|0 mm|0 mm|-10 mm|--direction|0|0|1|--hover|12 mm|--press|0 mm|"
                         "--stroke-angle|0 deg|--stroke-time|8 s|--tremor|0 mm");
  std::vector<std::string> words;
  for (std::string word; std::getline(all, word, '|');) words.push_back(word);
  return words;
}

std::string write_session(const std::string& folder) {
  std::string path = folder + "/woody.toml";
  std::ofstream(path) << R"([session]
name = "woody"
realtime = true
[device]
kind = "woodenhaptics"
max_force = "5 N"
[device.serial]
path = ")" << folder << R"(/device"
[coupling]
stiffness = "500 N/m"
[safety]
armed_at_start = true
soft_start = "0.1 s"
slew = "200 N/s"
[[object]]
name = "block"
primitive = "box"
extent = ["200 mm", "200 mm", "40 mm"]
position = ["0 mm", "0 mm", "-20 mm"]
)";
  return path;
}

/// The tip by the encoders when the server was answered [m].
Vec3 answered_position(const EmulatorRecord& r) {
  return tip_at(r.answered);
}

/// Depth of the tip below the plane, by the encoders [m].
double depth_at(const MotorCounts& counts) {
  return std::max(0.0, -tip_at(counts).z);
}

/// Whether this is the force k · depth, straight up, for the sample known to the server.
bool is_spring(const EmulatorRecord& r) {
  const Vec3 expected_B{0, 0, kStiffness * depth_at(r.answered)};
  return norm(r.force_B - expected_B) <= tol(kCurrentStep);
}

Records commands(Records records) {
  std::erase_if(records,
                [](const EmulatorRecord& r) { return r.event != EmulatorEvent::kCommand; });
  return records;
}

/// Commands after an instant.
Records commands_since(Records records, int64_t t_ns) {
  std::erase_if(records, [&](const EmulatorRecord& r) { return r.t_ns <= t_ns; });
  return commands(std::move(records));
}

/// Whether that many of the last commands are a firm press, each exactly the spring.
bool is_pressing(const Records& records, size_t n) {
  const Records all = commands(records);
  return all.size() >= n && std::all_of(all.end() - static_cast<std::ptrdiff_t>(n), all.end(),
                                        [](const EmulatorRecord& r) {
                                          return depth_at(r.answered) > 2e-3 && is_spring(r);
                                        });
}

/// Force bound: the spring at the deepest of the last answers plus the passivity damper, and the
/// limit of the device.
void check_never_too_much(const Records& records) {
  const Records all = commands(records);
  for (size_t k = 0; k < all.size(); ++k) {
    double deepest = 0, way = 0;
    for (size_t j = k >= 5 ? k - 5 : 0; j <= k; ++j) {
      const Vec3 p_B = answered_position(all[j]);
      deepest = std::max(deepest, -p_B.z);
      if (j > 0) way = std::max(way, norm(p_B - answered_position(all[j - 1])));
    }
    const double damper = kMaxDamping * way / kTick;
    CAPTURE(k, all[k].t_ns, all[k].force_B.x, all[k].force_B.y, all[k].force_B.z, deepest, damper);
    REQUIRE(norm(all[k].force_B) <= kStiffness * deepest + damper + tol(kCurrentStep));
    REQUIRE(norm(all[k].force_B) <= 5);
  }
}

/// 100 ms to the full force, so at most a hundredth more per millisecond; the emulator may have
/// been stalled for some of them.
void check_soft_start(Records::const_iterator begin, Records::const_iterator end) {
  const double full = kStiffness * 10e-3;
  for (auto r = begin; r != end && r->t_ns - begin->t_ns < 50 * kMs; ++r) {
    const double since_ms = static_cast<double>(r->t_ns - begin->t_ns) / kMs;
    REQUIRE(norm(r->force_B) <= full * (since_ms + 12) / 100 + tol(kCurrentStep));
  }
}

/// Checks that every command is a record: none was lost on its way to the file.
void check_complete(const Records& records) {
  uint64_t n = 0;
  for (const EmulatorRecord& r : commands(records)) REQUIRE(r.commands == ++n);
  for (size_t k = 1; k < records.size(); ++k) REQUIRE(records[k].t_ns >= records[k - 1].t_ns);
}

/// An emulator, a session on it, and a watcher; the hand presses.
struct Session {
  TemporaryRuntimeFolder folder;
  EmulatorProcess emulator;
  HapticdProcess hapticd;
  Watcher watcher;

  explicit Session(const std::string& hand = "typical")
      : emulator(pressing(hand), folder.path()),
        hapticd({write_session(folder.path())}, folder.path()),
        watcher("woody") {}

  bool wait_for_press(size_t n) {
    return watcher.wait_for_all() && eventually([&] {
             sleep_until(now_ns() + 20 * kMs);
             return is_pressing(emulator.records(), n);
           });
  }
};

}  // namespace

TEST_CASE("emulator: the hand receives k times depth, and zero at the end") {
  Session s;
  INFO(s.hapticd.log() << s.emulator.log());
  REQUIRE(s.wait_for_press(300));
  for (const pid_t pid : {s.hapticd.pid(), s.emulator.pid(), test::writer_of(s.watcher.servo),
                          test::writer_of(s.watcher.contact), test::writer_of(s.watcher.sim)}) {
    CHECK_FALSE(test::is_on_a_network(pid));
  }
  s.hapticd.send(SIGTERM);
  CHECK(s.hapticd.exit_code() == 0);
  s.emulator.send(SIGTERM);
  CHECK(s.emulator.exit_code() == 0);
  const Records records = s.emulator.records();
  check_complete(records);
  check_never_too_much(records);
  // the server's last command is zero, sent while the motors were still on
  const Records all = commands(records);
  CHECK(all.back().currents == Milliamperes{});
  CHECK(all.back().force_B == Vec3{});
  // the spring acts on the true position, not only on the encoder counts: within two encoder steps
  // of the hand when the server was answered
  constexpr double kSeen = kStiffness * 2 * 64e-6;
  for (size_t k = 1; k < all.size(); ++k) {
    if (all[k].force_B.z > 0.5 && is_spring(all[k])) {
      REQUIRE(std::fabs(all[k].force_B.z + kStiffness * all[k - 1].p_B.z) <= tol(kSeen));
    }
  }
  CHECK(s.emulator.said(std::to_string(all.size()) + " commands"));
}

TEST_CASE("emulator: each of the held hands is pushed back by k times depth") {
  const std::string hand = GENERATE("light-grip", "firm", "stiff-arm");
  CAPTURE(hand);
  Session s(hand);
  INFO(s.hapticd.log() << s.emulator.log());
  REQUIRE(eventually([&] {
    sleep_until(now_ns() + 20 * kMs);
    const Records all = commands(s.emulator.records());
    return all.size() > 200 && std::all_of(all.end() - 200, all.end(), [](const auto& r) {
             return r.force_B.z > 0.5 && is_spring(r);
           });
  }));
  check_never_too_much(s.emulator.records());
}

TEST_CASE("emulator: SIGKILL of the device is waited for, and its return begins softly") {
  Session s;
  INFO(s.hapticd.log());
  REQUIRE(s.wait_for_press(50));
  s.emulator.send(SIGKILL);
  s.emulator.exit_code();
  ServoFrame& f = s.watcher.servo_frame;
  REQUIRE(eventually([&] {
    s.watcher.servo.latest(f);
    return (f.device.flags & kDeviceLost) != 0;
  }));
  const uint64_t lost_at = f.tick;
  REQUIRE(eventually([&] { return s.watcher.servo.latest(f) && f.tick > lost_at + 300; }));
  CHECK((f.device.flags & kDeviceHeld) != 0);
  CHECK((f.device.flags & kDeviceFresh) == 0);
  CHECK((f.flags & kServoNoDevice) != 0);
  CHECK(f.F_device_B == Wrench{});
  CHECK(s.watcher.servo.generation() == 1);
  CHECK(eventually([&] { return s.hapticd.said("the device is gone"); }));

  // a servo that dies in the meantime is not restarted in vain
  kill(test::writer_of(s.watcher.servo), SIGKILL);
  CHECK(eventually([&] { return s.hapticd.said("starting it again when the device is back"); }));
  // the log of the first emulator must not count for the second
  std::filesystem::remove(s.folder.path() + "/received.csv");
  std::filesystem::remove(s.emulator.link());
  const EmulatorProcess again(pressing(), s.folder.path());
  REQUIRE(eventually([&] {
    sleep_until(now_ns() + 20 * kMs);
    return is_pressing(again.records(), 50);
  }));
  CHECK(s.hapticd.said("the device is back"));
  const Records all = commands(again.records());
  CHECK(all.front().force_B == Vec3{});
  check_never_too_much(again.records());
  check_soft_start(all.begin(), all.end());
  s.hapticd.send(SIGTERM);
  CHECK(s.hapticd.exit_code() == 0);
}

TEST_CASE("emulator: a node that is not there ends the start with one line") {
  const TemporaryRuntimeFolder folder;
  HapticdProcess hapticd({write_session(folder.path())}, folder.path());
  CHECK(hapticd.exit_code() == 2);
  CHECK(hapticd.said("plug the device in and switch it on, or correct 'path'"));
}

TEST_CASE("emulator: a device that is silent from the start ends it with one line") {
  const TemporaryRuntimeFolder folder;
  const EmulatorProcess emulator(pressing(), folder.path());
  emulator.send(SIGSTOP);
  HapticdProcess hapticd({write_session(folder.path())}, folder.path());
  const int code = hapticd.exit_code();
  emulator.send(SIGCONT);
  CHECK(code == 2);
  CHECK(hapticd.said("no answer within 2 s"));
}

TEST_CASE("emulator: hapticd lets go of the device for a servo that cannot, and replaces it") {
  Session s;
  INFO(s.hapticd.log());
  REQUIRE(s.wait_for_press(50));
  const int signal = GENERATE(SIGSTOP, SIGKILL);
  CAPTURE(signal);
  const pid_t servo = test::writer_of(s.watcher.servo);
  const int64_t stopped_ns = now_ns();
  kill(servo, signal);
  // hapticd replaces it; the new servo greets the device and starts softly
  REQUIRE(eventually([&] {
    return s.watcher.servo.latest(s.watcher.servo_frame) && s.watcher.servo.generation() == 2 &&
           is_pressing(commands_since(s.emulator.records(), stopped_ns), 50);
  }));
  const Records records = s.emulator.records();
  const Records all = commands_since(records, stopped_ns);
  const auto zero =
      std::ranges::find(all, Milliamperes{}, [](const EmulatorRecord& r) { return r.currents; });
  REQUIRE(zero != all.end());
  // not the firmware's watchdog; the fault tests check how fast, with a witness
  CHECK(std::none_of(records.begin(), records.end(), [&](const EmulatorRecord& r) {
    return r.event == EmulatorEvent::kWatchdog && r.t_ns > stopped_ns && r.t_ns <= zero->t_ns;
  }));
  // after a kill, the successor may have to command it first
  if (signal == SIGSTOP) {
    CHECK(eventually([&] { return s.hapticd.said("hapticd has let go of the device"); }));
  }
  // zero lasts until the new servo, which starts softly
  const auto pushes =
      std::find_if(zero, all.end(), [](const auto& r) { return r.currents != Milliamperes{}; });
  if (signal == SIGSTOP) CHECK(pushes->t_ns - zero->t_ns > 30 * kMs);
  check_soft_start(pushes, all.end());
  check_never_too_much(records);
}

TEST_CASE("emulator: a device that stops answering feels nothing old when it goes on") {
  Session s;
  INFO(s.hapticd.log());
  REQUIRE(s.wait_for_press(50));
  s.emulator.send(SIGSTOP);
  const bool noticed = eventually([&] {
    s.watcher.servo.latest(s.watcher.servo_frame);
    return (s.watcher.servo_frame.flags & kServoNoDevice) != 0;
  });
  // the timeout of the firmware's own watchdog
  sleep_until(now_ns() + 200 * kMs);
  const int64_t resumed_ns = now_ns();
  s.emulator.send(SIGCONT);
  REQUIRE(noticed);
  REQUIRE(eventually(
      [&] { return is_pressing(commands_since(s.emulator.records(), resumed_ns), 50); }));
  const Records records = s.emulator.records();
  const Records all = commands_since(records, resumed_ns);
  CHECK(all.front().force_B == Vec3{});
  check_soft_start(all.begin(), all.end());
  check_never_too_much(records);
}

TEST_CASE("emulator: wrong words on its command line are one line and change nothing") {
  const TemporaryRuntimeFolder folder;
  const auto [words, says] = GENERATE(table<std::vector<std::string>, std::string>({
      {{"--hand", "iron"}, "light-grip"},
      {{"--hover", "2 m"}, "does not reach"},
      {{"--six", "--hover", "2 m"}, "the arm does not reach"},
      {{"--six", "--turn-angle", "120 deg"}, "the wrist does not reach"},
      {{"--turn-angle", "20 deg"}, "give --six as well"},
      {{"--six", "--polhem"}, "are two devices"},
      {{"--polhem", "--hover", "2 m"}, "the arm does not reach"},
      {{"--hover", "50"}, "needs a unit"},
      {{"--stroke-time", "0 s"}, "--stroke-time: is zero"},
  }));
  test::ProgramProcess emulator("haptic-emulator", words, folder.path());
  CHECK(emulator.exit_code() == 2);
  CHECK(emulator.said(says));
  const std::string log = emulator.log();
  CHECK(std::count(log.begin(), log.end(), '\n') == 1);
}

TEST_CASE("emulator: a device that a person moves has nothing to lead") {
  Session s;
  REQUIRE(s.watcher.wait_for_all());
  CHECK(say_to_session("woody", "lead 0 0 0.01") ==
        "mistake: lead: the device is a real one: nothing to lead, move it by hand");
}

}  // namespace haptic
