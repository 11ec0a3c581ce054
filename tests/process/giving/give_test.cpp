// SPDX-License-Identifier: GPL-3.0-or-later
// A client moves an object of a real session: it is felt, ends, is killed, hangs and lies.
#include <catch2/catch.hpp>
#include <functional>
#include <string>

#include "clients/library/client.h"
#include "clients/library/giver.h"
#include "tests/process/hapt_command.h"
#include "tests/process/watcher.h"

namespace haptic {
namespace {

using namespace test;

/// The session of the example, which the watcher sees.
struct GivenSession {
  TemporaryRuntimeFolder folder;
  HapticdProcess hapticd{{from_source("configs/give.toml")}, folder.path()};
  Watcher watcher{"give"};

  GivenSession() { REQUIRE(watcher.wait_for_all()); }

  bool becomes(const std::function<bool(const SceneFrame&)>& holds) {
    return eventually([&] {
      watcher.sim.latest(watcher.scene);
      return holds(watcher.scene);
    });
  }
  bool is_felt() {
    return becomes([](const SceneFrame& scene) {
      return scene.objects[0].reduction == 0 && scene.objects[0].mover == moved_by_client(0);
    });
  }
  bool is_let_go() {
    return becomes([](const SceneFrame& scene) { return scene.objects[0].reduction == 1; });
  }
  std::string status() { return hapt("status", folder.path()).output; }
};

}  // namespace

TEST_CASE("give: a ball that a program integrates is felt, and its end is a fade") {
  GivenSession session;
  CHECK(has(session.status(), "giving     'ball' is not there\n"));
  {
    ProgramProcess ball("04_give", {}, session.folder.path());
    REQUIRE(session.is_felt());
    CHECK(has(session.status(), "giving     'ball' gives, pid " + std::to_string(ball.pid())));
    // the hand presses the ball away by more than it would a wall
    CHECK(session.becomes([](const SceneFrame& scene) {
      return norm(scene.objects[0].X_WO.p) > 5e-3 && scene.givers[0].refusal == 0;
    }));
    const bool is_killed = GENERATE(true, false);
    ball.send(is_killed ? SIGKILL : SIGSTOP);
    CHECK(session.is_let_go());
    const std::string status = session.status();
    INFO(status);
    CHECK(has(status, is_killed ? "'ball' is not there" : "late: what it gives is not felt"));
    if (!is_killed) {
      ball.send(SIGCONT);
      CHECK(session.is_felt());
    }
  }
  CHECK(session.is_let_go());
  // the next one under that name
  const ProgramProcess again("04_give", {}, session.folder.path());
  CHECK(session.is_felt());
  session.watcher.servo.latest(session.watcher.servo_frame);
  CHECK(session.watcher.servo_frame.fault == 0);
}

TEST_CASE("give: a client whose numbers are none is refused with a word, and nobody else suffers") {
  GivenSession session;
  Client client("give");
  Giver giver(client, "give", "ball");
  client.start();
  const auto spoilt = [&](const std::function<void(GivenMotion&)>& spoil) {
    GivenMotion motion{};
    motion.object = giver.object("ball");
    motion.mobility = free_mobility(0.1);
    giver.pushed(motion.object);
    spoil(motion);
    giver.move(motion);
    giver.publish();
  };
  REQUIRE(eventually([&] {
    spoilt([](GivenMotion&) {});
    session.watcher.sim.latest(session.watcher.scene);
    return session.watcher.scene.givers[0].t_ns != 0;
  }));
  CHECK(eventually([&] {
    spoilt([](GivenMotion& m) { m.X_WO.p.x = std::nan(""); });
    return has(session.status(), "refused: a number is not finite");
  }));
  CHECK(eventually([&] {
    spoilt([](GivenMotion& m) { m.object = 17; });
    return has(session.status(), "refused: it gives what it may not");
  }));
  CHECK(session.is_let_go());
  CHECK_THROWS_AS(Giver(client, "give", "bal"), HandoutError);
  CHECK_THROWS_AS(giver.object("bowl"), HandoutError);
  session.watcher.servo.latest(session.watcher.servo_frame);
  CHECK(session.watcher.servo_frame.fault == 0);
}

TEST_CASE("give: a session without [[client]] says how to add one") {
  TemporaryRuntimeFolder folder;
  const HapticdProcess hapticd({write_quiet_config(folder.path())}, folder.path());
  Watcher watcher("plane");
  REQUIRE(watcher.wait_for_all());
  const Ran ran = shell("04_give plane", folder.path());
  CHECK(ran.code == 1);
  CHECK(has(ran.output,
            "04_give: this session takes nothing of clients; add [[client]] with name = \"ball\""));
}

}  // namespace haptic
