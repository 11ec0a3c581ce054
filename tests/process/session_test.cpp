// SPDX-License-Identifier: GPL-3.0-or-later
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <fstream>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "proto/ipc/control_socket.h"
#include "proto/os/programs.h"
#include "tests/process/hapticd_process.h"
#include "tests/process/programs.h"
#include "tests/process/watcher.h"
#include "tests/support/data.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using namespace test;

/// A scene without files to read.
const std::string kPlane = test::from_source("configs/plane.toml");

/// The pid of a process of the session by what hapticd says; 0: none.
pid_t pid_of(const std::string& session, const std::string& name) {
  const std::string status = say_to_session(session, "status"), key = "\"" + name + "\", \"pid\": ";
  const size_t at = status.find(key);
  return at == status.npos ? 0 : std::max(std::stoi(status.substr(at + key.size())), 0);
}

/// The same with more at its end.
std::string write_scene(const std::string& folder, const std::string& end) {
  std::ofstream(folder + "/plane.toml") << std::ifstream(kPlane).rdbuf() << end;
  return folder + "/plane.toml";
}

}  // namespace

TEST_CASE("session: all rings flow, what is killed comes back alone, and SIGTERM ends it cleanly") {
  RunningSession session(kPlane, "flow");
  auto& [folder, hapticd, watcher] = session;
  CHECK(watcher.control_frame.revision == 1);
  CHECK(watcher.scene.objects.size() == 1);
  // the loop is closed: contact answers servo frames, the servo uses the answers and the scene
  CHECK(eventually([&] {
    watcher.servo.latest(watcher.servo_frame);
    return watcher.servo_frame.contact_seq > 0 && watcher.servo_frame.scene_seq > 0 &&
           watcher.servo_frame.control_revision == 1;
  }));
  const pid_t servo = writer_of(watcher.servo);
  kill(writer_of(watcher.contact), SIGKILL);
  CHECK(eventually([&] {
    return watcher.contact.latest(watcher.contact_set) && watcher.contact.generation() == 2;
  }));
  // far enough that a restart from zero would show
  REQUIRE(eventually([&] { return watcher.sim.latest(watcher.scene) && watcher.scene.seq > 20; }));
  const SceneFrame before = watcher.scene;
  kill(writer_of(watcher.sim), SIGKILL);
  CHECK(eventually(
      [&] { return watcher.sim.latest(watcher.scene) && watcher.sim.generation() == 2; }));
  // it goes on from its predecessor's last frame
  CHECK(watcher.scene.seq > before.seq);
  INFO(hapticd.log());
  CHECK(writer_of(watcher.servo) == servo);
  CHECK(watcher.servo.generation() == 1);
  kill(servo, SIGKILL);
  CHECK(eventually([&] {
    return watcher.servo.latest(watcher.servo_frame) && watcher.servo.generation() == 2;
  }));
  CHECK(hapticd.said("haptic-servo was killed: Killed; starting it again in 0 ms"));

  const std::vector<pid_t> children{writer_of(watcher.sim), writer_of(watcher.contact),
                                    writer_of(watcher.servo)};
  hapticd.send(SIGTERM);
  CHECK(hapticd.exit_code() == 0);
  CHECK_FALSE(std::filesystem::exists(folder.path() + "/flow.sock"));
  for (const pid_t child : children) CHECK_FALSE(test::is_alive(uint64_t(child)));
  CHECK(eventually([&] { return !watcher.attachments.is_connected(); }));
  // each process ended its loop by itself and reported it
  CHECK(watcher.servo.header()->state == uint32_t(SegmentState::kDead));
  for (const char* name : {"sim", "contact0", "servo0"}) {
    CHECK(hapticd.said(std::string(name) + ": stopped after"));
  }
}

TEST_CASE(
    "session: a sim that is killed, and killed while it starts, goes on from the last frame") {
  RunningSession session(kPlane, "again");
  auto& [folder, hapticd, watcher] = session;
  // in every frame that was ever published
  uint64_t n_frames = 0;
  const auto drain = [&] {
    for (SceneFrame next; watcher.sim.next(next); watcher.scene = next, ++n_frames) {
      REQUIRE(next.seq == watcher.scene.seq + 1);
      REQUIRE(next.t_ns > watcher.scene.t_ns);
    }
  };
  REQUIRE(eventually([&] { return drain(), n_frames > 10; }));
  pid_t last = 0;
  for (int k = 0; k < 4; ++k) {
    // those that take over are 0, 20 and 40 ms old
    REQUIRE(eventually([&] {
      drain();
      const pid_t now = pid_of("again", "sim");
      return now > 0 && std::exchange(last, now) != now;
    }));
    sleep_until(now_ns() + std::max(k - 1, 0) * 20'000'000);
    kill(last, SIGKILL);
  }
  const uint64_t before = n_frames;
  REQUIRE(eventually([&] { return drain(), n_frames > before + 10; }));
  INFO(hapticd.log());
  CHECK(watcher.sim.lost() == 0);
  CHECK(watcher.sim.generation() > 1);
}

TEST_CASE("session: what hangs is killed and replaced, and ends where hapticd is killed") {
  RunningSession session(kPlane, "hung");
  auto& [folder, hapticd, watcher] = session;
  const auto replaced = [&](auto& source, auto& item) {
    const uint64_t before = source.generation();
    kill(test::writer_of(source), SIGSTOP);
    return eventually([&] {
      source.latest(item);
      return source.generation() == before + 1;
    });
  };
  CHECK(replaced(watcher.sim, watcher.scene));
  CHECK(replaced(watcher.contact, watcher.contact_set));
  CHECK(replaced(watcher.servo, watcher.servo_frame));
  CHECK(hapticd.said("hangs: no cycle for "));
  const std::vector<pid_t> children{writer_of(watcher.sim), writer_of(watcher.contact),
                                    writer_of(watcher.servo)};
  hapticd.send(SIGKILL);
  CHECK(hapticd.exit_code() == -SIGKILL);
  for (const pid_t child : children) {
    CHECK(eventually([&] { return !test::is_alive(uint64_t(child)); }));
  }
  // nothing blocks the next one
  HapticdProcess next({kPlane, "--session", "hung"}, folder.path());
  Watcher again("hung");
  CHECK(again.wait_for_all());
}

namespace {

/// The spare contact; 0 if none has reported ready.
pid_t ready_spare(const std::string& session) {
  const std::string status = say_to_session(session, "status"), key = "\"spare\": {\"pid\": ";
  const size_t at = status.find(key);
  if (at == status.npos || status.find("\"ready\": true") == status.npos) return 0;
  return std::stoi(status.substr(at + key.size()));
}

/// A session whose spare is ready.
struct SparedSession : RunningSession {
  pid_t spare = 0;

  SparedSession() : RunningSession(kPlane, "spare") { REQUIRE(gets_spare_other_than(0)); }
  bool gets_spare_other_than(pid_t known) {
    return eventually([&] {
      spare = ready_spare("spare");
      return spare != 0 && spare != known;
    });
  }
  pid_t contact() { return writer_of(watcher.contact); }
  bool is_answered_by(pid_t writer) {
    return eventually(
        [&] { return watcher.contact.latest(watcher.contact_set) && contact() == writer; });
  }
};

}  // namespace

TEST_CASE("session: a contact that dies or hangs is replaced by the spare, which ends with it") {
  SparedSession s;
  for (const int signal : {SIGKILL, SIGSTOP}) {
    const pid_t before = s.contact(), spare = s.spare;
    CHECK(before != spare);
    kill(before, signal);
    CHECK(s.is_answered_by(spare));
    INFO(s.hapticd.log());
    // the replaced process is dead, not only silent
    CHECK_FALSE(test::is_alive(uint64_t(before)));
    CHECK(s.gets_spare_other_than(spare));
    CHECK(s.contact() == spare);
  }
  s.hapticd.send(SIGTERM);
  s.hapticd.exit_code();
  CHECK(eventually([&] { return !test::is_alive(uint64_t(s.spare)); }));
}

TEST_CASE("session: a spare that dies is replaced, one that hangs or dies too is not waited for") {
  SparedSession s;
  const auto is_answered_anew = [&](pid_t old) {
    return eventually(
        [&] { return s.watcher.contact.latest(s.watcher.contact_set) && s.contact() != old; });
  };
  const pid_t contact = s.contact(), first = s.spare;
  kill(first, SIGKILL);
  REQUIRE(s.gets_spare_other_than(first));
  CHECK(s.contact() == contact);
  const pid_t second = s.spare;
  kill(second, SIGSTOP);
  kill(contact, SIGKILL);
  CHECK(is_answered_anew(contact));
  INFO(s.hapticd.log());
  CHECK(s.contact() != second);
  CHECK_FALSE(test::is_alive(uint64_t(second)));
  // both at once: a new contact is started, and a new spare
  REQUIRE(s.gets_spare_other_than(second));
  const pid_t now = s.contact(), spare = s.spare;
  kill(spare, SIGKILL);
  kill(now, SIGKILL);
  CHECK(is_answered_anew(now));
  CHECK(s.contact() != spare);
  REQUIRE(s.gets_spare_other_than(spare));
  // the spare ends with its session, however that ends
  s.hapticd.send(SIGKILL);
  s.hapticd.exit_code();
  CHECK(eventually([&] { return !test::is_alive(uint64_t(s.spare)); }));
}

TEST_CASE(
    "session: where no spare is wanted none is started, and a dead contact still comes back") {
  const TemporaryRuntimeFolder folder;
  const std::string config = write_scene(folder.path(), "[contact]\nspare = false\n");
  const HapticdProcess hapticd({config, "--session", "alone"}, folder.path());
  Watcher watcher("alone");
  REQUIRE(watcher.wait_for_all());
  sleep_until(now_ns() + kNsPerSecond * 7 / 10);
  CHECK(say_to_session("alone", "status").find("\"spare\": {\"pid\": -1,") != std::string::npos);
  const pid_t contact = writer_of(watcher.contact);
  kill(contact, SIGKILL);
  CHECK(eventually([&] {
    return watcher.contact.latest(watcher.contact_set) && writer_of(watcher.contact) != contact;
  }));
}

TEST_CASE("session: what people ask for reaches the servo before they are answered") {
  RunningSession session(kPlane, "asked");
  auto& [folder, hapticd, watcher] = session;
  REQUIRE(eventually([&] { return watcher.servo.latest(watcher.servo_frame); }));
  const auto newest = [&] {
    REQUIRE(eventually([&] { return watcher.servo.latest(watcher.servo_frame); }));
    return watcher.servo_frame;
  };
  CHECK(say_to_session("asked", "pause") == "ok");
  CHECK((newest().flags & kServoPaused) != 0);
  CHECK(newest().F_device_B == Wrench{});
  CHECK(say_to_session("asked", "resume") == "ok");
  CHECK((newest().flags & kServoPaused) == 0);
  CHECK(say_to_session("asked", "disarm") == "ok");
  CHECK((newest().flags & kServoDisarmed) != 0);
  CHECK(say_to_session("", "arm") == "ok");
  CHECK((newest().flags & kServoDisarmed) == 0);
  CHECK(say_to_session("asked", "set stiffness 500 N/m") == "ok");
  CHECK(newest().control_revision == 6);
  CHECK(say_to_session("asked", "set stiffness 500") ==
        "mistake: stiffness: \"500\" needs a unit; write for example \"800 N/m\"; "
        "known units: N/m, N/mm, kN/m");
  const std::string status = say_to_session("asked", "status");
  CHECK(status.find("\"name\": \"servo0\"") != std::string::npos);
  CHECK(status.find("\"stiffness\": 500") != std::string::npos);
  // a silent servo is replaced; the request waits for its successor
  kill(writer_of(watcher.servo), SIGSTOP);
  const std::string said = say_to_session("asked", "pause");
  CHECK((said == "ok" || said.find("the servo did not apply it within a second") != said.npos));
  CHECK(eventually([&] {
    watcher.servo.latest(watcher.servo_frame);
    return watcher.servo.generation() == 2 && (watcher.servo_frame.flags & kServoPaused) != 0;
  }));
  CHECK(say_to_session("asked", "stop") == "ok");
  CHECK(hapticd.exit_code() == 0);
}

TEST_CASE(
    "session: a removed runtime folder is put back, unless another has taken the name meanwhile") {
  const TemporaryRuntimeFolder outer;
  const std::string folder = outer.path() + "/run";
  setenv("HAPTICD_RUNTIME_DIR", folder.c_str(), 1);
  const auto is_there = [] { return Watcher("lost").wait_for_all(); };
  HapticdProcess first({kPlane, "--session", "lost"}, outer.path());
  REQUIRE(is_there());
  // at once: deleting file by file would also delete what was restored in the meantime
  std::filesystem::rename(folder, outer.path() + "/removed");
  REQUIRE(eventually([&] { return first.said("put back"); }));
  // a second hapticd finds it there
  HapticdProcess late({kPlane, "--session", "lost"}, outer.path());
  CHECK(late.exit_code() == 1);
  CHECK(late.said("'lost' runs already"));
  CHECK(is_there());
  CHECK(say_to_session("lost", "pause") == "ok");

  first.send(SIGSTOP);
  std::filesystem::rename(folder, outer.path() + "/removed again");
  HapticdProcess second({kPlane, "--session", "lost"}, outer.path());
  REQUIRE(is_there());
  first.send(SIGCONT);
  CHECK(first.exit_code() != 0);
  CHECK(first.said("can no longer be reached and ends"));
  // its end has removed nothing of the second session
  CHECK(say_to_session("lost", "pause") == "ok");
  CHECK(say_to_session("lost", "stop") == "ok");
  CHECK(second.exit_code() == 0);
}

TEST_CASE("session: with a log that nobody reads it restarts, pauses and stops") {
  const TemporaryRuntimeFolder folder;
  std::array<int, 2> ends{};
  REQUIRE(pipe2(ends.data(), O_CLOEXEC) == 0);
  fcntl(ends[1], F_SETPIPE_SZ, 4096);
  const pid_t hapticd = fork();
  if (hapticd == 0) {
    dup2(ends[1], STDERR_FILENO);
    const std::string program = test::program_folder() / "hapticd";
    execl(program.c_str(), program.c_str(), kPlane.c_str(), "--session", "mute", nullptr);
    _exit(127);
  }
  Watcher watcher("mute");
  REQUIRE(watcher.wait_for_all());
  // certainly full, with no reader
  fcntl(ends[1], F_SETFL, O_NONBLOCK);
  while (write(ends[1], "x", 1) == 1) {
  }
  fcntl(ends[1], F_SETFL, 0);
  const pid_t servo = writer_of(watcher.servo);
  kill(servo, SIGKILL);
  CHECK(eventually([&] {
    watcher.servo.latest(watcher.servo_frame);
    return writer_of(watcher.servo) != servo;
  }));
  CHECK(say_to_session("mute", "pause") == "ok");
  CHECK(say_to_session("mute", "stop") == "ok");
  int status = 0;
  CHECK(eventually([&] { return waitpid(hapticd, &status, WNOHANG) == hapticd; }));
  CHECK((WIFEXITED(status) && WEXITSTATUS(status) == 0));
  for (const int end : ends) close(end);
}

TEST_CASE("session: bad input of one process ends the session, it is not tried again") {
  const TemporaryRuntimeFolder folder;
  const Programs programs(folder.path());
  programs.replace("haptic-servo", "exec sleep 1000");
  programs.replace("haptic-contact", "echo 'mesh.obj:3: not a number' >&2; exit 2");
  HapticdProcess hapticd({kPlane, "--session", "bad"}, folder.path());
  CHECK(hapticd.exit_code() == 2);
  CHECK(hapticd.said("mesh.obj:3: not a number"));
  CHECK(hapticd.said("haptic-contact cannot run with this input"));
  CHECK_FALSE(hapticd.said("starting it again"));
}

TEST_CASE("session: haptic-contact killed while it reads a mesh leaves the mesh's name") {
  const TemporaryRuntimeFolder folder;
  // a mesh that takes seconds to bake
  const std::string config =
      write_scene(folder.path(),
                  "\n[[object]]\nname = \"large\"\nprimitive = \"sphere\"\nsize = \"100 mm\"\n"
                  "subdivisions = 8\n");
  HapticdProcess hapticd({config, "--session", "large"}, folder.path());
  REQUIRE(eventually([&] { return hapticd.said("contact0: preparing primitive:sphere"); }));
  // as the kernel does when memory is exhausted
  const pid_t contact = pid_of("large", "contact0");
  REQUIRE(contact > 0);
  kill(contact, SIGKILL);
  CHECK(hapticd.exit_code() == kExitCrash);
  INFO(hapticd.log());
  CHECK(hapticd.said("was killed: Killed while it prepared primitive:sphere; the session ends"));
  CHECK(hapticd.said("hapt bake"));
  CHECK_FALSE(hapticd.said("starting it again"));
}

TEST_CASE("session: what keeps dying is started again ever more slowly, what is deaf is killed") {
  const TemporaryRuntimeFolder folder, other;
  setenv("HAPTICD_RUNTIME_DIR", folder.path().c_str(), 1);
  std::optional<HapticdProcess> deaf;
  {
    const Programs programs(other.path());
    programs.replace("haptic-servo", "exec sleep 1000");
    programs.replace("haptic-contact", "trap '' TERM; echo ready >&2; while :; do sleep 1; done");
    deaf.emplace(std::vector<std::string>{kPlane, "--session", "deaf"}, other.path());
    REQUIRE(eventually([&] { return deaf->said("ready"); }));
    deaf->send(SIGTERM);
  }
  const Programs programs(folder.path());
  programs.replace("haptic-servo", "exec sleep 1000");
  programs.replace("haptic-contact", "exit 1");
  HapticdProcess hapticd({kPlane, "--session", "loop"}, folder.path());
  std::vector<std::string> delays;
  CHECK(eventually([&] {
    delays.clear();
    std::istringstream lines(hapticd.log());
    const std::string key = "starting it again in ";
    for (std::string line; std::getline(lines, line);) {
      const size_t at = line.find(key);
      if (at != std::string::npos) delays.push_back(line.substr(at + key.size()));
    }
    return delays.size() >= 5;
  }));
  CHECK(delays == std::vector<std::string>{"0 ms", "50 ms", "200 ms", "1000 ms", "1000 ms"});
  // in the meantime the rest of the session runs
  Watcher watcher("loop");
  CHECK(eventually([&] { return watcher.sim.latest(watcher.scene); }));
  CHECK(watcher.sim.generation() == 1);
  // but not for ever: a process that never reaches its loop is given up
  CHECK(hapticd.exit_code() == 1);
  CHECK(hapticd.said("haptic-contact ended with exit code 1 8 times before it ran"));
  // meanwhile the process that does not listen was killed in the end
  CHECK(deaf->exit_code() == 0);
  CHECK(deaf->said("haptic-contact did not stop in time and is killed"));
}

TEST_CASE("session: a contact that is killed whenever it starts is started again for ever") {
  const TemporaryRuntimeFolder folder;
  HapticdProcess hapticd({kPlane, "--session", "killed"}, folder.path());
  Watcher watcher("killed");
  REQUIRE(eventually([&] { return watcher.contact.latest(watcher.contact_set); }));
  const auto contacts = [&] {
    std::vector<pid_t> found;
    const std::string children = "/proc/" + std::to_string(hapticd.pid()) + "/task/" +
                                 std::to_string(hapticd.pid()) + "/children";
    std::ifstream in(children);
    for (pid_t pid = 0; in >> pid;) {
      std::string name;
      std::getline(std::ifstream("/proc/" + std::to_string(pid) + "/comm") >> std::ws, name);
      if (name == "haptic-contact") found.push_back(pid);
    }
    return found;
  };
  // one more than what has never run is given; the spares too
  constexpr size_t kKills = 10;
  std::set<pid_t> killed;
  CHECK(eventually([&] {
    for (const pid_t pid : contacts()) {
      if (kill(pid, SIGKILL) == 0) killed.insert(pid);
    }
    return killed.size() >= kKills || !is_alive(static_cast<uint64_t>(hapticd.pid()));
  }));
  const uint64_t before = watcher.contact.generation();
  CHECK(eventually([&] {
    return watcher.contact.latest(watcher.contact_set) && watcher.contact.generation() > before;
  }));
  CHECK_FALSE(hapticd.said("times before it ran"));
}

TEST_CASE("session: with --log-json hapticd writes one object a line") {
  const TemporaryRuntimeFolder folder;
  const Programs programs(folder.path());
  // a process's own output gets the same form
  programs.replace("haptic-contact",
                   "echo 'haptic-contact: a \"quoted\" mesh' >&2; exec sleep 1000");
  programs.replace("haptic-servo", "exec sleep 1000");
  HapticdProcess hapticd({kPlane, "--session", "json", "--log-json"}, folder.path());
  REQUIRE(
      eventually([&] { return hapticd.said("\"source\":\"sim\",\"message\":\"started: pid "); }));
  CHECK(eventually([&] {
    return hapticd.said("\"source\":\"contact0\",\"message\":\"a \\\"quoted\\\" mesh\"}");
  }));
  hapticd.send(SIGTERM);
  CHECK(hapticd.exit_code() == 0);
  std::istringstream lines(hapticd.log());
  for (std::string line; std::getline(lines, line);) {
    CAPTURE(line);
    CHECK(line.rfind("{\"time\":\"", 0) == 0);
    CHECK(line.back() == '}');
  }
}

}  // namespace haptic
