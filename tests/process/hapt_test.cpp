// SPDX-License-Identifier: GPL-3.0-or-later
// The command line tool as people and scripts use it, on the real binaries.
#include <algorithm>
#include <fstream>

#include "clients/lab/support/forked_process.h"
#include "proto/log/trace.h"
#include "proto/os/programs.h"
#include "tests/process/hapt_command.h"
#include "tests/process/watcher.h"
#include "tests/support/data.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using namespace test;

std::string plane_config() {
  return test::from_source("configs/plane.toml");
}

/// A recorded hand that presses 2 mm into the block of plane.toml, at this rate.
void write_hand(const std::string& path, double rate, double seconds) {
  std::ofstream csv(path);
  csv << "t_s,x_m,y_m,z_m\n";
  csv.precision(12);
  for (int i = 0; i <= static_cast<int>(seconds * rate); ++i) {
    const double t = i / rate;
    csv << t << ",0," << std::max(0.041 - 0.006 * t / seconds, 0.038) << ",0\n";
  }
}

/// The plane, and three balls of which two have nothing below them. They have fallen 200 mm after
/// 0.2 s. Returns the path.
std::string write_falling_balls(const std::string& folder) {
  const std::string path = folder + "/falling.toml";
  std::ofstream out(path);
  out << read_config_text(plane_config())
      << "[sim]\ngravity = [\"0 m/s²\", \"-9.81 m/s²\", \"0 m/s²\"]\nreach = \"200 mm\"\n";
  const auto add = [&](const std::string& name, double x, double y, const std::string& more) {
    out << "[[object]]\nname = \"" << name << "\"\nposition = [\"" << x << " m\", \"" << y
        << " m\", \"0 m\"]\n"
        << more;
  };
  const std::string ball =
      "primitive = \"sphere\"\nsize = \"20 mm\"\n[object.body]\nmass = \"10 g\"\n";
  add("left", -0.3, 0, ball);
  add("right", 0.3, 0, ball);
  add("held", 0.6, 0, ball);
  add("floor", 0.6, -0.06, "primitive = \"box\"\nextent = [\"100 mm\", \"100 mm\", \"100 mm\"]\n");
  return path;
}

}  // namespace

TEST_CASE("hapt status, top, demo: bodies that fell out of reach are counted, with the remedy") {
  const std::string told =
      "2 bodies out of reach (0.2 m): raise reach in [sim], or put a floor below";
  const TemporaryFolder scene;
  const std::string config = write_falling_balls(scene.path());
  {
    const RunningSession session(config, "falling");
    const std::string folder = session.folder.path();
    Ran status;
    CHECK(eventually([&] {
      status = hapt("status", folder);
      return has(status.output, "\nscene      " + told + "\n");
    }));
    INFO(status.output);
    CHECK(has(hapt("status --json", folder).output, "\"out_of_reach\": 2, \"reach\": 0.2}"));
    CHECK(has(hapt("top -n 1 -d 100ms -b", folder).output, "\n" + told + "\n"));
    CHECK(has(hapt("top -n 1 -d 100ms --json", folder).output, "\"out_of_reach\": 2}"));
  }
  const TemporaryRuntimeFolder folder;
  const Ran demo = hapt("demo --config " + config + " --for 1 -o falling.mcap", folder.path());
  INFO(demo.output);
  CHECK(demo.code == 0);
  CHECK(has(demo.output, told + "; next: "));
}

TEST_CASE("hapt demo: the simulated hand touches, nothing is lost, exit 0") {
  const TemporaryRuntimeFolder folder;
  const Ran ran =
      hapt("demo --config plane.toml --for 2 -o run.mcap --plot run.svg --report", folder.path());
  INFO(ran.output);
  CHECK(ran.code == 0);
  CHECK(has(ran.output, "SIMULATED hand, seed 1, closed loop"));
  CHECK(has(ran.output, "run.mcap"));
  CHECK(has(ran.output, "\npassed: 2 s with session 'plane', "));
  CHECK(has(ran.output, "real-time"));
  CHECK(std::filesystem::file_size(folder.path() + "/run.svg") > 1000);

  // the log can be replayed as a recorded hand, open loop
  const Ran again = hapt("replay run.mcap --config plane.toml -o again.mcap --json", folder.path());
  INFO(again.output);
  CHECK(again.code == 0);
  CHECK(figure(again.output, "samples lost") == 0);
  CHECK(figure(again.output, "ticks in contact") > 0);
  CHECK(has(again.output, "\"note\": \"RECORDED hand "));
  // without a session file named, in the session that is inside
  const Ran inside = hapt("replay run.mcap -o inside.mcap --for 0.5", folder.path());
  CHECK(inside.code == 0);
  CHECK(has(inside.output, "playing the session inside run.mcap"));
  CHECK(has(inside.output, "with session 'plane'"));
  const Ran table = hapt("export again.mcap -o again.csv", folder.path());
  CHECK(table.code == 0);
  CHECK(std::filesystem::file_size(folder.path() + "/again.csv") > 100000);
  const TraceReader log(folder.path() + "/again.mcap");
  CHECK(log.mcap().metadata().at("realtime").contains("servo"));
}

TEST_CASE("hapt demo: a hand that touches nothing is no success") {
  const TemporaryRuntimeFolder folder;
  std::ofstream(folder.path() + "/free.toml") << R"([session]
name = "free"
[device]
kind = "simulated-hand"
)";
  const Ran ran = hapt("demo --config free.toml --for 0.5 -o free.mcap --json", folder.path());
  INFO(ran.output);
  CHECK(ran.code == 1);
  CHECK(figure(ran.output, "ticks in contact") == 0);
}

TEST_CASE("hapt demo: Ctrl-C keeps what was recorded and a killed demo leaves no session") {
  const int signal = GENERATE(SIGINT, SIGHUP, SIGKILL);
  const TemporaryRuntimeFolder folder;
  const std::string program = (test::program_folder() / "hapt").string();
  const std::string log = folder.path() + "/cut.mcap";
  const pid_t hapt_pid = fork();
  if (hapt_pid == 0) {
    const int null = open("/dev/null", O_WRONLY);
    dup2(null, STDOUT_FILENO);
    dup2(null, STDERR_FILENO);
    execl(program.c_str(), "hapt", "demo", "--config", "plane.toml", "--session", "cut", "-o",
          log.c_str(), nullptr);
    _exit(127);
  }
  pid_t servo = 0;
  {
    Watcher watcher("cut");
    REQUIRE(watcher.wait_for_all());
    // frames, not ticks: a stalled machine skips some
    int frames = 0;
    REQUIRE(eventually([&] {
      while (watcher.servo.next(watcher.servo_frame)) ++frames;
      return frames > 800;
    }));
    servo = test::writer_of(watcher.servo);
    kill(hapt_pid, signal);
    int status = 0;
    waitpid(hapt_pid, &status, 0);
    if (signal != SIGKILL) {
      CHECK(WIFEXITED(status));
      CHECK(WEXITSTATUS(status) == 1);
    }
    CHECK(eventually([&] { return !watcher.attachments.is_connected(); }));
  }
  CHECK(eventually([&] { return !test::is_alive(static_cast<uint64_t>(servo)); }));
  const TraceReader trace(log);
  CHECK(trace.mcap().finished() == (signal != SIGKILL));
  CHECK(trace.read(servo_topic(kFirstHand)).size() > 400);
}

TEST_CASE("hapt replay: every grid point of the recorded hand is played, whatever its rate") {
  const double rate = GENERATE(100.0, 1000.0, 2000.0);
  const TemporaryRuntimeFolder folder;
  write_hand(folder.path() + "/hand.csv", rate, 0.5);
  const Ran ran = hapt("replay hand.csv --config plane.toml --json", folder.path());
  INFO(ran.output);
  CHECK(ran.code == 0);
  CHECK(figure(ran.output, "samples of the recorded hand") == rate / 2 + 1);
  CHECK(figure(ran.output, "frames plus counted skips") == 501);
  CHECK(figure(ran.output, "samples lost") == 0);
}

TEST_CASE("hapt replay: faster, again and again, and as the intention of a simulated hand") {
  const TemporaryRuntimeFolder folder;
  write_hand(folder.path() + "/hand.csv", 500, 2);
  const auto replayed = [&](const std::string& words) {
    const Ran ran =
        hapt("replay hand.csv --config plane.toml -o out.mcap --overwrite " + words, folder.path());
    CAPTURE(words, ran.output);
    CHECK(ran.code <= 1);  // a part of the hand need not touch
    return TraceReader(folder.path() + "/out.mcap").read(servo_topic(kFirstHand));
  };
  const auto fast = replayed("--speed 4 --from 1s --to 2s");
  // in ticks: those that a busy machine skips are counted, and no other is missing
  const auto ticks = [](const std::vector<ServoFrame>& frames) {
    REQUIRE_FALSE(frames.empty());
    const ServoFrame &first = frames.front(), &last = frames.back();
    CHECK(frames.size() + last.skipped - first.skipped == last.tick - first.tick + 1);
    return last.tick - first.tick + 1;
  };
  // a quarter of a second of it, and as long as it takes to stop the session
  CHECK(ticks(fast) > 240);
  CHECK((fast.back().device.flags & kDeviceEnded) != 0);
  const auto looped = replayed("--from 1.9s --loop --for 0.5s");
  CHECK(ticks(looped) >= 490);
  CHECK((looped.back().device.flags & kDeviceEnded) == 0);
  const auto led = replayed("--to 0.5s --closed-loop");
  REQUIRE(led.size() > 100);
  const auto moved = [](const ServoFrame& frame) { return norm(frame.device.V_BH.v) > 0; };
  CHECK(std::any_of(led.begin(), led.end(), moved));
}

TEST_CASE("hapt export, hapt replay: a recording of an older layout, and once what it lacks") {
  const TemporaryRuntimeFolder folder;
  const std::string log = test::from_source("tests/proto/log/golden/layout_6.mcap");
  const Ran sets = hapt("export " + log + " --topic /contact0/set -o sets.csv", folder.path());
  INFO(sets.output);
  CHECK(sets.code == 0);
  CHECK(has(sets.output, "layout_6.mcap: recorded with layout 6; fields it lacks: skipped ("));
  CHECK(has(sets.output, ", objects[].clearance (one value for all)"));
  CHECK(has(sets.output, "4 rows of /contact0/set"));
  CHECK(lines(sets.output) == 2);

  const Ran played = hapt("replay " + log + " --config plane.toml --json", folder.path());
  INFO(played.output);
  CHECK(
      has(played.output, "layout_6.mcap: recorded with layout 6; fields it lacks: device.F_hand"));
  CHECK(figure(played.output, "samples of the recorded hand") == 10);
  CHECK(figure(played.output, "samples lost") == 0);
}

namespace {

void check_top(const std::string& folder) {
  const Ran screen = hapt("top --session live -b -n 2 -d 0.2", folder);
  INFO(screen.output);
  CHECK(screen.code == 0);
  for (const char* name : {"servo0", "contact0", "sim"}) CHECK(has(screen.output, name));
  CHECK(has(screen.output, "force"));
  // the first screen already covers a whole period; skipped grid points are not frames
  const Ran json = hapt("top --session live -n 1 -d 0.5 --json", folder);
  INFO(json.output);
  CHECK(json.code == 0);
  CHECK(lines(json.output) == 1);
  CHECK(has(json.output, "\"missed\": 0}"));
  const std::string key = "\"servo0\": {\"state\": \"run\", \"generation\": 1, \"rate_hz\": ";
  REQUIRE(has(json.output, key));
  const double rate = std::stod(json.output.substr(json.output.find(key) + key.size()));
  CHECK(rate > 500);
  CHECK(rate < 1100);
  // Ctrl-C ends it at once, however long its period, as soon as it catches the signal
  const int64_t start_ns = now_ns();
  const Ran ended = shell(
      "hapt top -d 100000 & pid=$!; "
      "until grep -q '^SigCgt:.*[2367abef]$' /proc/$pid/status; do sleep 0.05; done; "
      "kill -INT $pid; wait $pid",
      folder);
  CHECK(ended.code == 0);
  CHECK(now_ns() - start_ns < 20 * kNsPerSecond);
}

void check_status(const std::string& folder) {
  // hapticd may map the servo's segment a moment after the watcher
  Ran open;
  REQUIRE(eventually([&] {
    open = hapt("status", folder);
    return has(open.output, "force      open\n");
  }));
  INFO(open.output);
  CHECK(open.code == 0);
  CHECK(has(open.output, "session    live, since 20"));
  CHECK(has(open.output, "renderer   god-object3, stiffness 800 N/m\ndevice     simulated-hand\n"));
  CHECK(has(open.output, "servo0, pid "));
  CHECK(hapt("pause", folder).code == 0);
  CHECK(has(hapt("status", folder).output, "force      closed: paused ('hapt resume')\n"));
  const Ran json = hapt("status --json", folder);
  CHECK(lines(json.output) == 1);
  CHECK(has(json.output, "\"force\": \"closed\", \"closed_by\": [\"paused ('hapt resume')\"]"));
  CHECK(has(json.output, "\"session\": \"live\""));
}

/// Recorded by name, until told to stop.
void check_record(const std::string& folder) {
  const std::string file = folder + "/live.mcap";
  const Ran ran = hapt("record -o live.mcap --for 0.5 --config plane.toml --json", folder);
  INFO(ran.output);
  CHECK(ran.code == 0);
  CHECK(has(ran.output, "\"topic\": \"/servo0/frame\", \"recorded\": "));
  const TraceReader trace(file);
  CHECK(trace.mcap().finished());
  CHECK(trace.read(servo_topic(kFirstHand)).size() > 200);
  bool named = false;
  for (const auto& [name, facts] : trace.mcap().metadata()) {
    if (!facts.contains("session")) continue;
    named = facts.at("session") == "live" && has(facts.at("config"), "[session]");
  }
  CHECK(named);
  // --overwrite is required; Ctrl-C is the normal end
  const Ran cut = shell(
      "hapt record -o live.mcap --overwrite >said 2>&1 & pid=$!; "
      "until grep -q 'recording to' said; do sleep 0.05; done; sleep 0.3; "
      "kill -INT $pid; wait $pid; code=$?; cat said; exit $code",
      folder);
  INFO(cut.output);
  CHECK(cut.code == 0);
  CHECK(has(cut.output, "/servo0/frame: "));
  CHECK(TraceReader(file).mcap().finished());
}

}  // namespace

TEST_CASE("hapt top, record and status, and example 01, look at a session they did not start") {
  const RunningSession session(plane_config(), "live");
  const std::string folder = session.folder.path();
  check_top(folder);
  check_record(folder);
  test::ProgramProcess watch("01_watch", {"live"}, folder);
  CHECK(eventually([&] { return lines(watch.log()) > 2; }));
  const Ran none = shell("01_watch missing", folder);
  CHECK(none.code != 0);
  CHECK(has(none.output, "no session 'missing' is running (looked in "));
  // a demo of the same name leaves it, and its log, alone
  const Ran taken = hapt("demo --config plane.toml --session live --for 1 -o taken.mcap", folder);
  INFO(taken.output);
  CHECK(taken.code == 1);
  CHECK(has(taken.output, "hapticd ended before the session was up"));
  CHECK_FALSE(std::filesystem::exists(folder + "/taken.mcap"));
  CHECK(test::is_alive(static_cast<uint64_t>(session.hapticd.pid())));
  // at last: it pauses the session
  check_status(folder);
}

TEST_CASE("hapt: --wait lets a command be typed before its session is up") {
  const TemporaryRuntimeFolder folder;
  const std::string command = GENERATE(as<std::string>(), "pause", "top -n 1 -d 100ms",
                                       "record -o waited.mcap --for 100ms");
  const Ran ran = shell("(sleep 0.3; exec hapticd " + plane_config() + " 2>log) & hapt " + command +
                            " --wait 60s; code=$?; hapt status --json; hapt stop; wait; exit $code",
                        folder.path());
  INFO(ran.output);
  CHECK(ran.code == 0);
  CHECK(has(ran.output, "\"paused\": " + std::string(command == "pause" ? "true" : "false")));
}

TEST_CASE("hapt bench ring: a figure and its peer for each size, and what it takes to publish") {
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
  WARN("SKIPPED: a sanitizer's figures say nothing, and its pace outlasts the limit of real time");
  return;
#endif
  if (allowed_processors().size() < 2) {
    WARN("SKIPPED: needs two processors");
    return;
  }
  const TemporaryRuntimeFolder folder;
  const Ran ran = hapt("bench ring --rounds 1 --json", folder.path());
  INFO(ran.output);
  // whether the goals are met depends on the machine
  CHECK((ran.code == 0 || ran.code == 1));
  CHECK((ran.code == 1) == has(ran.output, "\"holds\": false"));
  for (const std::string size : {"64", "256", "1024", "8192"}) {
    CAPTURE(size);
    CHECK(figure(ran.output, size + " B, one way p50") > 10e-9);
    CHECK(figure(ran.output, size + " B, one way p99") < 1);
    CHECK(figure(ran.output, size + " B, throughput, nothing lost") > 1000);
  }
  CHECK(has(ran.output, "\"peer\": \"boost::lockfree::spsc_queue\", \"peer_value\": "));
  CHECK(figure(ran.output, "publish at 1 kHz, one fast reader p99") > 0);
  CHECK(figure(ran.output, "8 stopped readers over one fast, publish p50") > 0);
  const Ran alone = shell("taskset -c 0 hapt bench ring --rounds 1", folder.path());
  CHECK(alone.code == 1);
  CHECK(has(alone.output, "this process may use only one"));
}

}  // namespace haptic
