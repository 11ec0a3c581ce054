// SPDX-License-Identifier: GPL-3.0-or-later
// Clearance over recordings that are written here, against FCL and against distances in closed
// form.
#include "clients/report/clearance.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "clients/lab/bench/peers/pair.h"
#include "clients/log/trace_writer.h"
#include "clients/report/clearance_print.h"
#include "clients/report/report.h"
#include "device-io/hand/waypoints.h"
#include "proto/log/trace.h"
#include "proto/math/units.h"
#include "proto/os/message.h"
#include "proto/wire/mapping.h"
#include "proto/wire/renderer.h"
#include "tests/support/data.h"
#include "tests/support/frames.h"
#include "tests/support/near.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/torture_scale.h"

namespace haptic {
namespace {

using namespace test;

// of mesh_distance and of FCL: edges that are nearly parallel, a few roundings each [m]
constexpr double kAgree = 1e-9;

/// A recording of a tool at poses of 1 kHz, as contact has proven them or as the servo has placed
/// its proxy; `scene` may move objects.
struct Recorded {
  TemporaryFolder folder;
  std::string log = folder.path() + "/log.mcap";

  template <typename PoseAt>
  Recorded(const std::string& config, Renderer renderer, size_t n, const PoseAt& pose_at,
           const SceneFrame* scene = nullptr) {
    const SessionConfig session = parse_config(config, "x.toml");
    TraceWriter trace(log, recording_metadata("made", config));
    if (scene != nullptr) trace.write(kSimTopic, *scene, {scene->t_ns, scene->t_ns, 0});
    for (uint64_t tick = 0; tick < n; ++tick) {
      ServoFrame frame{};
      frame.tick = tick;
      frame.t_ns = frame.realtime_ns = kMs * static_cast<int64_t>(tick + 1);
      frame.contact_tick = frame.contact_seq = tick;
      frame.renderer = static_cast<uint32_t>(renderer);
      ContactSet set{};
      set.seq = set.answers_tick = tick;
      set.answers_t_ns = frame.t_ns;
      set.renderer = frame.renderer;
      // what must not be looked at is far away
      set.X_WG = frame.X_WP = {{9, 9, 9}, {}};
      (is_rigid(renderer) ? set.X_WG : frame.X_WP) = pose_at(tick);
      for (uint32_t i = 0; i < session.n_objects; ++i) {
        set.objects.push_back({session.objects[i].X_WO, 0});
      }
      const Stamp stamp{frame.t_ns, frame.realtime_ns, tick};
      trace.write(contact_topic(kFirstHand), set, stamp);
      trace.write(servo_topic(kFirstHand), frame, stamp);
    }
    REQUIRE(trace.close());
  }
};

/// Two cubes of 20 mm, of which the tool stands at x [m].
const std::string kCubes =
    "[session]\nname = \"cubes\"\nrenderer = \"god-object6\"\n"
    "[tool]\nprimitive = \"box\"\nextent = [\"20 mm\", \"20 mm\", \"20 mm\"]\n"
    "[device]\nkind = \"simulated-hand\"\n"
    "[coupling]\nrotational_stiffness = \"2 N·m/rad\"\n"
    "[[object]]\nname = \"a\\u001b\"\nprimitive = \"box\"\n"
    "extent = [\"20 mm\", \"20 mm\", \"20 mm\"]\n"
    "[[object]]\nname = \"far\"\nprimitive = \"box\"\n"
    "extent = [\"1 m\", \"1 m\", \"1 m\"]\nposition = [\"0 m\", \"0 m\", \"2 m\"]\n";

Clearance measured(const Recorded& recorded, const ClearanceOptions& options = {}) {
  const SessionConfig config = carried_session(recorded.log);
  return measure_clearance(recorded.log, config, bake_surfaces(config), options);
}

Pose along_x(double x) {
  return {{x, 0, 0}, {}};
}

}  // namespace

TEST_CASE("clearance: FCL's distance at 1,000 recorded poses, within 1e-9 m", "[clearance]") {
  // the scene's own path: through the opening and down to the pins
  const std::string text = read_config_text(from_source("configs/frame.toml"));
  const SessionConfig config = parse_config(text, "frame.toml");
  const IntentConfig& intent = config.device.hand.intent;
  double end = 0;
  for (uint32_t i = 0; i < intent.n_waypoints; ++i) {
    end += intent.waypoints[i].time + intent.waypoints[i].rest;
  }
  const size_t poses = kSlowdown > 1 ? 100 : 1000;
  const auto pose_at = [&](uint64_t tick) {
    const Intent at =
        along_waypoints(intent, end * static_cast<double>(tick) / static_cast<double>(poses));
    return tool_pose(config.map, {}, {at.p_B, at.q_B});
  };
  const Recorded recorded(text, config.renderer, poses, pose_at);
  const BakedSession baked = bake_surfaces(config);
  const Clearance clearance = measure_clearance(recorded.log, config, baked, {});
  REQUIRE(clearance.samples.size() == poses);
  REQUIRE(clearance.proven == poses);
  REQUIRE(clearance.tightest.size() == 2);
  for (const Tightest& one : clearance.tightest) {
    const auto fcl = make_fcl_peer(baked.objects[one.object].shape.mesh, baked.tool->shape.mesh);
    INFO("without FCL nothing is compared: install libfcl-dev and configure again");
    REQUIRE(fcl != nullptr);
    const Pose X_OW = inverse(config.objects[one.object].X_WO);
    double least = 1, worst = 0;
    for (uint64_t tick = 0; tick < poses; ++tick) {
      const double theirs = std::max(fcl->distance(X_OW * pose_at(tick)), 0.0);
      const double ours = clearance.samples[tick].distances[one.object];
      CAPTURE(one.object, tick, ours, theirs);
      REQUIRE(std::abs(ours - theirs) <= tol(kAgree));
      worst = std::max(worst, std::abs(ours - theirs));
      least = std::min(least, theirs);
    }
    CAPTURE(worst);
    CHECK(std::abs(one.distance - least) <= tol(kAgree));
    // both points are on the way from one surface to the other
    if (one.distance > 0) {
      CHECK(norm(one.tool_point_W - one.object_point_W) == Approx(one.distance).epsilon(1e-9));
    }
  }
  // the opening is passed with about a millimetre on each side; on the pins the intention presses
  CHECK(clearance.tightest[0].distance > 1e-3);
  CHECK(clearance.tightest[0].distance < 1.5e-3);
  CHECK(clearance.tightest[1].distance == 0);
}

TEST_CASE("clearance: the distance of two cubes, where it is least, and the points",
          "[clearance]") {
  // to and fro: nearest after 100 ticks, 3 mm away
  const auto x = [](uint64_t tick) {
    return 0.023 + 1e-4 * std::abs(static_cast<double>(tick) - 100);
  };
  const Recorded recorded(kCubes, Renderer::kGodObject6, 300,
                          [&](uint64_t tick) { return along_x(x(tick)); });
  const Clearance clearance = measured(recorded);
  REQUIRE(clearance.samples.size() == 300);
  for (uint64_t tick = 0; tick < 300; ++tick) {
    REQUIRE_THAT(clearance.samples[tick].distances[0],
                 Catch::WithinAbs(x(tick) - 0.02, tol(1e-15)));
  }
  const Tightest& one = clearance.tightest[0];
  CHECK(clearance.nearest() == 0);
  CHECK(one.tick == 100);
  CHECK(one.t == Approx(0.1));
  CHECK(one.tool_point_W.x == Approx(0.013));
  CHECK(one.object_point_W.x == Approx(0.01));
  CHECK(one.X_WT == along_x(x(100)));
  CHECK(clearance.tightest[1].distance == Approx(2 - 0.5 - 0.01));

  SECTION("of one object alone, and fewer poses") {
    const Clearance few =
        measured(recorded, {.every = 0.05, .object = "far", .told = [](double) {}});
    CHECK(few.samples.size() == 6);
    REQUIRE(few.tightest.size() == 1);
    CHECK(few.tightest[0].object == 1);
    CHECK(few.samples[1].tick == 50);
  }
  SECTION("as JSON, as a table and as a drawing, with foreign bytes escaped") {
    const SessionConfig config = carried_session(recorded.log);
    std::ostringstream json, table;
    print_clearance_json(json, recorded.log, config, clearance);
    const auto read = nlohmann::json::parse(json.str());
    CHECK(read["nearest"] == 0);
    CHECK(read["objects"][0]["name"] == "a\x1b");
    CHECK(read["objects"][0]["distance_m"] == one.distance);
    CHECK(read["objects"][0]["tick"] == 100);
    CHECK(read["samples"].size() == 300);
    CHECK(read["samples"][299]["distance_m"][0] == clearance.samples[299].distances[0]);
    print_clearance(table, recorded.log, config, clearance);
    CHECK(table.str().find('\x1b') == std::string::npos);
    CHECK(table.str().find("a\\x1b") != std::string::npos);
    CHECK(table.str().find(readable(one.distance, "m")) != std::string::npos);
    const std::string svg = recorded.folder.path() + "/x.svg";
    plot_clearance(svg, recorded.log, config, clearance);
    std::ostringstream drawing;
    drawing << std::ifstream(svg).rdbuf();
    const std::string drawn = drawing.str();
    CHECK(drawn.find('\x1b') == std::string::npos);
    CHECK(drawn.find("<circle class=\"ring\"") != std::string::npos);
    CHECK(drawn.find(">" + readable(one.distance, "m") + "</text>") != std::string::npos);
  }
}

TEST_CASE("clearance: bodies that meet, or one inside of the other, have none", "[clearance]") {
  const Recorded meet(kCubes, Renderer::kGodObject6, 3, [](uint64_t tick) {
    return along_x(0.03 - 0.005 * static_cast<double>(tick));
  });
  const Clearance at = measured(meet);
  CHECK(at.samples[0].distances[0] == Approx(0.01));
  CHECK(at.samples[2].distances[0] == 0);
  // wholly inside of the large one: its surface is half a metre away
  const Recorded inside(kCubes, Renderer::kGodObject6, 2, [](uint64_t) {
    return Pose{{0, 0, 2}, {}};
  });
  CHECK(measured(inside).samples[0].distances[1] == 0);
}

TEST_CASE(
    "clearance: of a tool that may enter it is that of the servo's proxy, among objects that "
    "move",
    "[clearance]") {
  const SessionConfig config = parse_config(kCubes, "x.toml");
  SceneFrame scene{};
  scene.t_ns = 1 * kMs;
  for (uint32_t i = 0; i < 2; ++i) {
    scene.objects.push_back(scene_object(config.objects[i].X_WO, {}, scene.t_ns));
  }
  scene.objects[0].V_WO.v = {1, 0, 0};  // towards the tool, a millimetre in each tick
  const Recorded recorded(
      kCubes, Renderer::kDirect6, 10, [](uint64_t) { return along_x(0.05); }, &scene);
  const Clearance clearance = measured(recorded);
  REQUIRE(clearance.samples.size() == 10);
  CHECK(clearance.proven == 0);
  for (uint64_t tick = 0; tick < 10; ++tick) {
    CHECK(clearance.samples[tick].distances[0] == Approx(0.03 - 1e-3 * static_cast<double>(tick)));
  }
  CHECK(clearance.tightest[0].tick == 9);
}

TEST_CASE("clearance: what cannot be measured is refused in one line", "[clearance]") {
  const auto at = [](uint64_t) { return along_x(0.03); };
  const Recorded good(kCubes, Renderer::kGodObject6, 3, at);
  CHECK_THROWS_WITH(measured(good, {.every = 0, .object = "fra", .told = [](double) {}}),
                    Catch::Contains("has no object 'fra'") && Catch::Contains("far"));
  const Recorded point(kCubes, Renderer::kGodObject3, 3, at);
  CHECK_THROWS_WITH(measured(point), Catch::Contains("has no pose of a tool with six degrees"));
  const TemporaryFolder folder;
  const std::string log = folder.path() + "/none.mcap";
  TraceWriter trace(log, recording_metadata("made", ""));
  REQUIRE(trace.close());
  CHECK_THROWS_WITH(carried_session(log), Catch::Contains("has no session file inside"));
  SessionConfig bare = carried_session(good.log);
  bare.tool = {};
  CHECK_THROWS_WITH(measure_clearance(good.log, bare, bake_surfaces(bare), {}),
                    Catch::Contains("is a point or a sphere"));
}

}  // namespace haptic
