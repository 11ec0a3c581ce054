// SPDX-License-Identifier: GPL-3.0-or-later
// A session of 200 boxes, some with mass: it runs, is drawn, recorded and played again.
#include <fstream>
#include <sstream>
#include <string>

#include "clients/library/client.h"
#include "proto/log/trace.h"
#include "tests/process/hapt_command.h"
#include "tests/process/watcher.h"

namespace haptic {
namespace {

using namespace test;

constexpr int kBoxes = 200, kBodies = 20;

/// Boxes of 6 mm in a square, 8 mm from each other; the last ones have mass, and nothing pulls at
/// them.
std::string boxes_in(const std::string& folder) {
  std::ostringstream text;
  text << "[session]\nname = \"many\"\nrealtime = false\n[device]\nkind = \"simulated-hand\"\n"
          "[device.hand.intent]\nhover_radius = \"40 mm\"\npress_radius = \"2 mm\"\n"
          "[coupling]\nstiffness = \"500 N/m\"\n";
  for (int i = 0; i < kBoxes; ++i) {
    const int x = 8 * (i % 15 - 7), y = 8 * (i / 15 - 7);
    text << "[[object]]\nname = \"box " << i << "\"\nprimitive = \"box\"\n"
         << "extent = [\"6 mm\", \"6 mm\", \"6 mm\"]\n"
         << "position = [\"" << x << " mm\", \"" << y << " mm\", \"0 mm\"]\n";
    if (i >= kBoxes - kBodies) text << "[object.body]\nmass = \"5 g\"\n";
  }
  const std::string path = folder + "/many.toml";
  std::ofstream(path) << text.str();
  return path;
}

}  // namespace

TEST_CASE("session: 200 boxes run, are drawn, recorded and played again") {
  TemporaryRuntimeFolder folder;
  const HapticdProcess hapticd({boxes_in(folder.path())}, folder.path());
  Watcher watcher("many");
  REQUIRE(watcher.wait_for_all());
  CHECK(watcher.scene.objects.size() == kBoxes);
  CHECK(watcher.scene.responses.size() == kBodies);
  CHECK(eventually([&] {
    return watcher.contact.latest(watcher.contact_set) &&
           watcher.contact_set.objects.size() == kBoxes;
  }));

  // each box is a path of its own, and the tool
  REQUIRE(shell("02_draw boxes.svg many", folder.path()).code == 0);
  std::ostringstream drawing;
  drawing << std::ifstream(folder.path() + "/boxes.svg").rdbuf();
  int paths = 0;
  for (size_t at = 0; (at = drawing.str().find("<path", at)) != std::string::npos; ++at) ++paths;
  CHECK(paths == kBoxes + 1);

  const Ran recorded = hapt("record --for 500ms -o many.mcap", folder.path());
  INFO(recorded.output);
  REQUIRE(recorded.code == 0);
  CHECK(has(recorded.output, "nothing lost"));
  const TraceReader trace(folder.path() + "/many.mcap");
  size_t frames = 0;
  trace.for_each<SceneFrame>(kSimTopic, [&](const SceneFrame& scene, const Stamp&) {
    REQUIRE(scene.objects.size() == kBoxes);
    REQUIRE(scene.objects[kBoxes - kBodies].response == 0);
    REQUIRE(scene.objects[0].response == kNoResponse);
    ++frames;
  });
  CHECK(frames > 100);

  REQUIRE(hapt("stop --session many", folder.path()).code == 0);
  const Ran played = hapt("replay many.mcap --for 200ms -o again.mcap", folder.path());
  INFO(played.output);
  CHECK(played.code == 0);
  CHECK(TraceReader(folder.path() + "/again.mcap").read(servo_topic(kFirstHand)).size() > 100);
}

}  // namespace haptic
