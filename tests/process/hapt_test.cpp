// SPDX-License-Identifier: GPL-3.0-or-later
// The command line tool as people and scripts use it, on the real binaries.
#include <algorithm>
#include <fstream>

#include "clients/lab/forked_process.h"
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

/// A recorded hand that presses 2 mm into the block of plane.toml, at this rate, for two seconds.
void write_hand(const std::string& path, double rate) {
  std::ofstream csv(path);
  csv << "t_s,x_m,y_m,z_m\n";
  csv.precision(12);
  for (int i = 0; i <= static_cast<int>(2 * rate); ++i) {
    const double t = i / rate;
    csv << t << ",0," << (t < 1 ? 0.041 - 0.003 * t : 0.038) << ",0\n";
  }
}

}  // namespace

TEST_CASE("hapt demo: the simulated hand touches, nothing is lost, exit 0") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  const Ran ran =
      hapt("demo --config plane.toml --for 4 -o run.mcap --plot run.svg --report", folder.path());
  INFO(ran.output);
  CHECK(ran.code == 0);
  CHECK(has(ran.output, "SIMULATED hand, seed 1, closed loop"));
  CHECK(has(ran.output, "run.mcap"));
  CHECK(has(ran.output, "\npassed: 4 s with session 'plane', "));
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
  const Ran inside = hapt("replay run.mcap -o inside.mcap --for 1", folder.path());
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
  if (!programs_are_built()) return;
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

TEST_CASE("hapt demo: a name that is taken leaves the other session and its log alone") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  HapticdProcess hapticd({plane_config(), "--session", "taken"}, folder.path());
  Watcher watcher("taken");
  REQUIRE(watcher.wait_for_all());
  const Ran ran =
      hapt("demo --config plane.toml --session taken --for 1 -o taken.mcap", folder.path());
  INFO(ran.output);
  CHECK(ran.code == 1);
  CHECK(has(ran.output, "hapticd ended before the session was up"));
  CHECK_FALSE(std::filesystem::exists(folder.path() + "/taken.mcap"));
  CHECK(test::is_alive(static_cast<uint64_t>(hapticd.pid())));
}

TEST_CASE("hapt demo: Ctrl-C keeps what was recorded and a killed demo leaves no session") {
  if (!programs_are_built()) return;
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
      return frames > 1500;
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
  CHECK(trace.read(servo_topic(kFirstHand)).size() > 1000);
}

TEST_CASE("hapt replay: every grid point of the recorded hand is played, whatever its rate") {
  if (!programs_are_built()) return;
  const double rate = GENERATE(100.0, 1000.0, 2000.0);
  const TemporaryRuntimeFolder folder;
  write_hand(folder.path() + "/hand.csv", rate);
  const Ran ran = hapt("replay hand.csv --config plane.toml --json", folder.path());
  INFO(ran.output);
  CHECK(ran.code == 0);
  CHECK(figure(ran.output, "samples of the recorded hand") == 2 * rate + 1);
  CHECK(figure(ran.output, "frames plus counted skips") == 2001);
  CHECK(figure(ran.output, "samples lost") == 0);
}

TEST_CASE("hapt replay: faster, again and again, and as the intention of a simulated hand") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  write_hand(folder.path() + "/hand.csv", 500);
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
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  const std::string log = test::from_source("tests/proto/log/golden/layout_6.mcap");
  const Ran sets = hapt("export " + log + " --topic /contact0/set -o sets.csv", folder.path());
  INFO(sets.output);
  CHECK(sets.code == 0);
  CHECK(has(sets.output, "layout_6.mcap: recorded with layout 6; fields it lacks: clearance[] ("));
  CHECK(has(sets.output, "4 rows of /contact0/set"));
  CHECK(lines(sets.output) == 2);

  const Ran played = hapt("replay " + log + " --config plane.toml --json", folder.path());
  INFO(played.output);
  CHECK(
      has(played.output, "layout_6.mcap: recorded with layout 6; fields it lacks: device.F_hand"));
  CHECK(figure(played.output, "samples of the recorded hand") == 10);
  CHECK(figure(played.output, "samples lost") == 0);
}

TEST_CASE("hapt: what cannot start says so in one line, exit 2 if a file is wrong, else 1") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  const auto [words, code] = GENERATE(table<std::string, int>({
      {"demo --config missing.toml", 2},
      {"top -n 1", 1},
      {"record -o x.mcap", 1},
      {"export missing.mcap", 2},
      {"replay missing.csv --config lever.toml", 2},
      {"eval --config missing.toml", 2},
      {"demo --plot /nowhere/x.svg", 1},
      {"replay . -o x.mcap", 2},
      {"demo -o /nowhere/x.mcap", 1},
      {"record -o /", 1},
  }));
  const Ran ran = hapt(words, folder.path());
  CAPTURE(words, ran.output);
  CHECK(ran.code == code);
  CHECK(lines(ran.output) == 1);
  CHECK(ran.output.rfind("hapt: ", 0) == 0);
}

TEST_CASE("hapt: what is typed wrongly is named in one line, exit 2") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  struct Typed {
    const char* words;
    const char* says;
  };
  const Typed typed = GENERATE(values<Typed>({
      {"bogus", "hapt: there is no command 'bogus'; see hapt --help"},
      {"", "hapt: a command is missing; see hapt --help"},
      {"demo --for abc", "known units: s, ms, us, µs, min, h; see hapt demo --help"},
      {"demo --for nan", "\"nan\" is not a finite number"},
      {"eval --for -1", "--for: is out of range (\"-1\")"},
      {"record -o x --for 0", "--for: is out of range (\"0\")"},
      {"top -n -1", "-1"},
      {"top -d 1e9", "is out of range (\"1e9\")"},
      {"demo --bogus", "there is no option '--bogus'; see hapt demo --help"},
      {"demo --out x", "there is no option '--out'; did you mean '--output'?"},
      {"demmo", "there is no command 'demmo'; did you mean 'demo'?"},
      {"help demmo", "there is no command 'demmo'; did you mean 'demo'?"},
      {"bench jiter", "there is no command 'jiter'; did you mean 'jitter'?"},
      {"demo bunny peg", "'peg' is one word too many; see hapt demo --help"},
      {"demo --for", "--for needs a value; see hapt demo --help"},
      {"bake x.off --band 1mm", "--band requires --voxel; add it"},
      {"demo peg --config x.toml", "--config excludes SCENE; leave one out"},
      {"top -n x", "-n: is 'x'; write a whole number"},
      {"demo --plot x.png", "--plot: the drawing is an SVG; name it with .svg at the end"},
      {"export", "RECORDING is missing"},
  }));
  const Ran ran = hapt(typed.words, folder.path());
  CAPTURE(typed.words, ran.output);
  CHECK(ran.code == 2);
  CHECK(lines(ran.output) == 1);
  CHECK(ran.output.rfind("hapt: ", 0) == 0);
  CHECK(has(ran.output, typed.says));
}

TEST_CASE("hapt: nothing that was recorded is overwritten unasked") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  write_hand(folder.path() + "/hand.csv", 1000);
  // refused by name, before anything is read
  std::ofstream(folder.path() + "/hand.mcap") << "an old recording";
  std::ofstream(folder.path() + "/old.svg") << "an old plot";
  struct Run {
    const char* words;
    const char* says;
  };
  const Run run = GENERATE(values<Run>({
      {"export hand.mcap -o hand.mcap", "is read and would be overwritten"},
      {"export hand.mcap -o hand.mcap --overwrite", "is read and would be overwritten"},
      {"export hand.mcap -o ./hand.csv", "exists; choose another name or add --overwrite"},
      {"replay hand.mcap --config plane.toml -o hand.mcap --overwrite", "is read and would"},
      {"replay hand.csv --config plane.toml -o hand.mcap", "exists; choose another name"},
      {"demo --config plane.toml -o hand.mcap", "exists; choose another name"},
      {"demo --config plane.toml -o new.svg --plot new.svg", "is to be written twice"},
      {"demo --config plane.toml -o new.mcap --plot old.svg", "exists; choose another name"},
      {"eval --config plane.toml --for 1 --plot old.svg", "exists; choose another name"},
      {"record -o hand.mcap", "exists; choose another name"},
  }));
  const auto sizes = [&] {
    return std::vector{std::filesystem::file_size(folder.path() + "/hand.csv"),
                       std::filesystem::file_size(folder.path() + "/hand.mcap"),
                       std::filesystem::file_size(folder.path() + "/old.svg")};
  };
  const auto before = sizes();
  const Ran ran = hapt(run.words, folder.path());
  CAPTURE(run.words, ran.output);
  CHECK(ran.code == 1);
  CHECK(lines(ran.output) == 1);
  CHECK(has(ran.output, run.says));
  CHECK(sizes() == before);
}

TEST_CASE("hapt: half a table on a full device is a failure") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  REQUIRE(hapt("demo --config plane.toml --for 1 -o run.mcap", folder.path()).code <= 1);
  const std::string words =
      GENERATE(as<std::string>(), "export run.mcap >/dev/full", "export run.mcap >&-",
               "eval --config plane.toml --for 1 --json >/dev/full", "--version >/dev/full");
  const Ran ran = hapt(words, folder.path());
  CAPTURE(words, ran.output);
  CHECK(ran.code == 1);
  CHECK(has(ran.output, "hapt: standard output cannot be written"));
}

TEST_CASE("hapt top: shows the three processes of a running session") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  HapticdProcess hapticd({plane_config(), "--session", "top"}, folder.path());
  Watcher watcher("top");
  REQUIRE(watcher.wait_for_all());
  const Ran screen = hapt("top --session top -b -n 2 -d 0.2", folder.path());
  INFO(screen.output);
  CHECK(screen.code == 0);
  for (const char* name : {"servo0", "contact0", "sim"}) CHECK(has(screen.output, name));
  CHECK(has(screen.output, "force"));
  // the first screen already covers a whole period; skipped grid points are not frames
  const Ran json = hapt("top --session top -n 1 -d 1 --json", folder.path());
  INFO(json.output);
  CHECK(json.code == 0);
  CHECK(lines(json.output) == 1);
  CHECK(has(json.output, "\"missed\": 0}"));
  const std::string key = "\"servo0\": {\"state\": \"run\", \"generation\": 1, \"rate_hz\": ";
  REQUIRE(has(json.output, key));
  const double rate = std::stod(json.output.substr(json.output.find(key) + key.size()));
  CHECK(rate > 500);
  CHECK(rate < 1100);
}

TEST_CASE("hapt status: for people, and one object for scripts") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  HapticdProcess hapticd({plane_config(), "--session", "asked"}, folder.path());
  Watcher watcher("asked");
  REQUIRE(watcher.wait_for_all());
  // hapticd may map the servo's segment a moment after the watcher
  Ran open;
  REQUIRE(eventually([&] {
    open = hapt("status", folder.path());
    return has(open.output, "force      open\n");
  }));
  INFO(open.output);
  CHECK(open.code == 0);
  CHECK(has(open.output, "session    asked, since 20"));
  CHECK(has(open.output, "renderer   god-object3, stiffness 800 N/m\ndevice     simulated-hand\n"));
  CHECK(has(open.output, "servo0, pid "));
  CHECK(hapt("pause", folder.path()).code == 0);
  CHECK(has(hapt("status", folder.path()).output, "force      closed: paused ('hapt resume')\n"));
  const Ran json = hapt("status --json", folder.path());
  CHECK(lines(json.output) == 1);
  CHECK(has(json.output, "\"force\": \"closed\", \"closed_by\": [\"paused ('hapt resume')\"]"));
  CHECK(has(json.output, "\"session\": \"asked\""));
}

TEST_CASE("hapt: --wait lets a command be typed before its session is up") {
  if (!programs_are_built()) return;
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

TEST_CASE("hapt top: Ctrl-C ends it at once, however long its period") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  HapticdProcess hapticd({plane_config(), "--session", "top"}, folder.path());
  Watcher watcher("top");
  REQUIRE(watcher.wait_for_all());
  const int64_t start_ns = now_ns();
  shell("hapt top -d 100000 & pid=$!; sleep 0.5; kill -INT $pid; wait $pid", folder.path());
  CHECK(now_ns() - start_ns < 20 * kNsPerSecond);
}

TEST_CASE("hapt record: a session it did not start is recorded, by name, until told to stop") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  HapticdProcess hapticd({plane_config(), "--session", "live"}, folder.path());
  Watcher watcher("live");
  REQUIRE(watcher.wait_for_all());
  const Ran ran = hapt("record -o live.mcap --for 0.5 --config plane.toml --json", folder.path());
  INFO(ran.output);
  CHECK(ran.code == 0);
  CHECK(has(ran.output, "\"topic\": \"/servo0/frame\", \"recorded\": "));
  const TraceReader trace(folder.path() + "/live.mcap");
  CHECK(trace.mcap().finished());
  CHECK(trace.read(servo_topic(kFirstHand)).size() > 200);
  bool named = false;
  for (const auto& [name, facts] : trace.mcap().metadata()) {
    if (!facts.contains("session")) continue;
    named = facts.at("session") == "live" && has(facts.at("config"), "[session]");
  }
  CHECK(named);

  // --overwrite is required; Ctrl-C is the normal end
  const Ran cut =
      shell("hapt record -o live.mcap --overwrite & pid=$!; sleep 1; kill -INT $pid; wait $pid",
            folder.path());
  INFO(cut.output);
  CHECK(cut.code == 0);
  CHECK(has(cut.output, "/servo0/frame: "));
  CHECK(TraceReader(folder.path() + "/live.mcap").mcap().finished());
}

TEST_CASE("hapt eval: the chain on virtual time holds and repeats") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  const Ran ran = hapt("eval --config plane.toml --for 4 --json --plot eval.svg", folder.path());
  INFO(ran.output);
  CHECK(ran.code == 0);
  CHECK(figure(ran.output, "repeats that differ, of 1") == 0);
  CHECK(figure(ran.output, "ticks") == 4000);
  CHECK(figure(ran.output, "ticks in contact") > 100);
  CHECK(std::filesystem::file_size(folder.path() + "/eval.svg") > 1000);
}

TEST_CASE("hapt bench ring: a figure and its peer for each size, and what it takes to publish") {
  if (!programs_are_built()) return;
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

TEST_CASE("example 01: prints the pose of a running session") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  HapticdProcess hapticd({plane_config(), "--session", "watched"}, folder.path());
  Watcher watcher("watched");
  REQUIRE(watcher.wait_for_all());
  const Ran ran = shell("timeout 1 01_watch watched", folder.path());
  INFO(ran.output);
  CHECK(lines(ran.output) > 2);
  const Ran none = shell("01_watch missing", folder.path());
  CHECK(none.code != 0);
  CHECK(has(none.output, "no session 'missing' is running (looked in "));
}

}  // namespace haptic
