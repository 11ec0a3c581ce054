// SPDX-License-Identifier: GPL-3.0-or-later
// A client of a real session draws: viewers get it whole, the children never map it, and it goes
// with who drew it.
#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>

#include "clients/library/client.h"
#include "clients/library/drawer.h"
#include "clients/library/giver.h"
#include "tests/process/hapt_command.h"
#include "tests/process/watcher.h"

namespace haptic {
namespace {

using namespace test;

/// A session of two clients, of which the first may draw.
std::string write_drawn_config(const std::string& folder) {
  std::ofstream(folder + "/drawn.toml") << read_config_text(write_quiet_config(folder))
                                        << "\n[[client]]\nname = \"painter\"\nmay = [\"draw\"]\n"
                                           "\n[[client]]\nname = \"other\"\nmay = [\"push\"]\n";
  return folder + "/drawn.toml";
}

struct DrawnSession {
  TemporaryRuntimeFolder folder;
  HapticdProcess hapticd{{write_drawn_config(folder.path())}, folder.path()};
  Watcher watcher{"plane"};

  DrawnSession() { REQUIRE(watcher.wait_for_all()); }
};

/// A viewer, as the bridge is one.
struct DrawnViewer {
  Client client{"plane"};
  DrawingReader drawings{client.ring<&DrawChannels::pieces>(Start::kOldest)};
  RingSource<& ControlChannels::frames> control =
      client.ring<&ControlChannels::frames>(Start::kOldest);
  ControlFrame frame{};

  DrawnViewer() { client.start(); }
  /// Looks until so many points are shown.
  bool shows(size_t n_points) {
    return eventually([&] {
      drawings.read(1000);
      control.latest(frame);
      drawings.forget_unless(frame.giving[0]);
      return drawings.newest().points.size() == n_points;
    });
  }
};

struct Painter {
  Client client{"plane"};
  Giver giver{client, "plane", "painter"};
  Drawer drawer{giver.seat()};
};

std::vector<DrawnPoint> dots(size_t n) {
  std::vector<DrawnPoint> points(n);
  for (DrawnPoint& point : points) point.radius = 1e-3;
  return points;
}

bool maps_drawings(pid_t pid) {
  std::ifstream maps("/proc/" + std::to_string(pid) + "/maps");
  const std::string text(std::istreambuf_iterator<char>(maps), {});
  REQUIRE(text.find("sim") != std::string::npos);
  return text.find("draw0") != std::string::npos;
}

}  // namespace

TEST_CASE("draw: viewers see a drawing whole, the children map nothing of it, and it ends") {
  DrawnSession session;
  DrawnViewer early;
  auto painter = std::make_unique<Painter>();
  const auto points = dots(200'000);
  const std::vector<DrawnLine> lines(20'000);
  REQUIRE(painter->drawer.draw(points, lines));
  CHECK(early.shows(200'000));
  CHECK(early.drawings.newest().lines.size() == 20'000);
  CHECK_FALSE(painter->drawer.draw(points, lines));
  // a drawing that stands is shown to who comes later
  DrawnViewer late;
  CHECK(late.shows(200'000));
  CHECK(maps_drawings(getpid()));
  for (const pid_t child : {writer_of(session.watcher.servo), writer_of(session.watcher.contact),
                            writer_of(session.watcher.sim)}) {
    CHECK_FALSE(maps_drawings(child));
  }
  CHECK(eventually([&] { return painter->drawer.draw(dots(3)); }));
  CHECK(early.shows(3));
  painter.reset();
  CHECK(early.shows(0));
  CHECK(late.shows(0));
  // the next one under that name
  CHECK(eventually([&] {
    try {
      painter = std::make_unique<Painter>();
    } catch (const HandoutError&) {
    }
    return painter != nullptr;
  }));
  REQUIRE(painter->drawer.draw(dots(5)));
  CHECK(early.shows(5));
  session.watcher.servo.latest(session.watcher.servo_frame);
  CHECK(session.watcher.servo_frame.fault == 0);
}

TEST_CASE("hapt top: a line of each client that may give") {
  DrawnSession session;
  const Painter painter;
  const std::string there = "'painter' gives, pid " + std::to_string(getpid());
  const std::string& folder = session.folder.path();
  std::string said;
  CHECK(eventually([&] {
    said = hapt("top -n 1 -d 100ms -b", folder).output;
    return has(said, "\nclient " + there) && has(said, "\nclient 'other' is not there\n");
  }));
  INFO(said);
  CHECK(has(hapt("top -n 1 -d 100ms --json", folder).output, "\"giving\": [\"" + there));
}

TEST_CASE("draw: who may not is told how to allow it") {
  DrawnSession session;
  Client client("plane");
  Giver other(client, "plane", "other");
  CHECK_THROWS_WITH(Drawer(other.seat()),
                    "this client may not draw; add \"draw\" to may of its [[client]]");
}

}  // namespace haptic
