// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/measurement.h"

#include <unistd.h>

#include <algorithm>
#include <memory>
#include <stdexcept>

#include "clients/lab/bench/peers/pair.h"
#include "clients/lab/bench/workloads/proximity.h"
#include "clients/lab/bench/workloads/turns.h"
#include "clients/lab/eval/scenes/rigid_scenes.h"
#include "clients/lab/eval/way_left.h"
#include "clients/lab/support/scan.h"
#include "clients/lab/support/thread_cpu.h"
#include "clients/library/histogram.h"
#include "contact/detect/contact_model.h"
#include "contact/query/proximity/near_front.h"
#include "contact/shape/mesh/tool_body.h"
#include "proto/config/command_line.h"
#include "proto/math/units.h"
#include "proto/os/progress.h"
#include "proto/os/realtime.h"
#include "proto/wire/look_ahead.h"

namespace haptic {
namespace {

constexpr double kClearance = 0.05e-3;  // of the peg in the hole [m]
constexpr double kAheadTicks = 3;       // look-ahead of a session, in ticks of hand motion
constexpr double kGoalRate = 500;       // moves per second of CPU time
constexpr uint64_t kPeerSamples = 25;   // poses at which FCL is timed
constexpr double kBandMargins = 8;      // band around a settled pose, in margins
constexpr double kJamMargins = 10;      // feasible motion of a jammed pose, in margins
constexpr double kBlindWay = 0.1e-3;    // [m]; a settled tool farther from the hand needs a contact
constexpr int64_t kShowNs = 500'000'000;  // [ns]; between two progress lines

struct Options {
  std::vector<std::string> scenes{"bunny", "peg", "bolt"};
  uint64_t frames = 2000, seed = 1, exact = 10'000, rests = 2000;
  std::string meshes;
};

/// The initial pose of bolt_through_nut.
RigidScene bolt_in_nut() {
  const auto bolt = std::make_shared<const ProximityWork>(bolt_through_nut(1));
  return {bolt->name, bolt->object.view(), bolt->tool.view(),
          bolt,       bolt->poses[0],      {{3e-3, 3e-3, 3e-3}, {0.2, 0.2, 0.4}, {}}};
}

/// Every n-th frame, at most `most` of them.
bool is_sample(uint64_t frame, uint64_t frames, uint64_t most) {
  return frame % std::max<uint64_t>(1, (frames + most - 1) / most) == 0;
}

/// The god-object alone, in the frame of the object.
class Subject {
 public:
  explicit Subject(const RigidScene& scene)
      : objects_{scene.object},
        body_(tool_body(scene.tool.mesh, {})),
        options_(god_object_options({}, body_)),
        god_object_(objects_, scene.tool, body_, options_) {
    if (!god_object_.place(X_WO_, scene.home)) {
      throw std::runtime_error("bench rigid: " + scene.name + " begins at a pose that is not free");
    }
    // the first move builds the fronts, as before the start of a session
    god_object_.move(X_WO_, scene.home, kLeastBodyReach);
  }

  GodObjectMove move(const Pose& hand, const Pose& hand_before) {
    const Twist way = way_between(hand_before, hand);
    const double length = norm(way.v) + (norm(body_.centre_T) + body_.radius) * norm(way.w);
    return god_object_.move(X_WO_, hand, std::max(kAheadTicks * length, kLeastBodyReach));
  }
  size_t contacts(const Pose& hand) { return god_object_.contacts(hand).size(); }
  const Pose& pose() const { return god_object_.X_WG(); }
  const GodObject6Options& options() const { return options_; }

 private:
  std::array<MeshShape, 1> objects_;
  ToolBody body_;
  GodObject6Options options_;
  GodObject6 god_object_;
  std::array<Pose, 1> X_WO_{};
};

/// Totals of a run, of constant size.
struct Tally {
  Histogram cpu, clock;
  double cpu_ns = 0, first_ns = 0, contacts = 0, pressed = 0, blind = 0, unsettled = 0;
  double exact = 0, entered = 0, met = 0;                // poses whose surfaces intersect
  double rests = 0, unknown = 0, jams = 0, longest = 0;  // longest: feasible motion [m]
  std::vector<double> peer;                              // [s]
};

/// Checks a sample of poses exactly and the others by a separate front that is given the poses
/// only: from scratch, a tight fit takes many times as long as a move.
void judge_pose(const Pose& pose, bool is_exact, const WayLeftJudge& judge, NearFront& front,
                Tally& tally) {
  if (is_exact) {
    ++tally.exact;
    tally.entered += judge.is_entered(pose);
  } else {
    tally.met += !front.update(pose, 0).empty();
  }
}

void judge_rest(const Subject& subject, const Pose& hand, WayLeftJudge& judge, Tally& tally) {
  const double margin = subject.options().margin;
  const WayLeft left = judge.way_left(subject.pose(), hand, margin, kBandMargins * margin);
  ++tally.rests;
  tally.unknown += !left.is_known;
  if (!left.is_known) return;
  tally.jams += left.length > kJamMargins * margin;
  tally.longest = std::max(tally.longest, left.length);
}

Tally shake(const RigidScene& scene, const ShakingHand& hand, const Options& options) {
  Subject subject(scene);
  WayLeftJudge judge(
      scene.object, scene.tool,
      {subject.options().translational_stiffness, subject.options().rotational_stiffness});
  NearFront front(scene.object, scene.tool);
  const std::unique_ptr<PairPeer> peer = make_fcl_peer(scene.object.mesh, scene.tool.mesh);
  Progress progress("shaking " + scene.name, static_cast<double>(options.frames));
  Tally tally;
  Pose before = hand.at(0);
  for (uint64_t k = 0; k < options.frames; ++k) {
    progress.at(static_cast<double>(k));
    const Pose led = hand.at(kTick * static_cast<double>(k));
    GodObjectMove move;
    const int64_t start_ns = now_ns();
    const int64_t cpu = cpu_ns_of([&] { move = subject.move(led, before); });
    tally.clock.add(now_ns() - start_ns);
    tally.cpu.add(cpu);
    tally.cpu_ns += static_cast<double>(cpu);
    if (k == 0) tally.first_ns = static_cast<double>(cpu);
    before = led;
    const size_t contacts = subject.contacts(led);
    tally.contacts += static_cast<double>(contacts);
    tally.blind += move.is_settled && contacts == 0 && norm(led.p - subject.pose().p) > kBlindWay;
    tally.pressed += move.n_active > 0;
    tally.unsettled += !move.is_settled;
    const bool is_exact = is_sample(k, options.frames, options.exact);
    judge_pose(subject.pose(), is_exact, judge, front, tally);
    if (move.is_settled && is_sample(k, options.frames, options.rests)) {
      judge_rest(subject, led, judge, tally);
    }
    if (peer && is_sample(k, options.frames, kPeerSamples)) {
      tally.peer.push_back(cpu_seconds_of([&] { peer->distance(subject.pose()); }));
    }
  }
  return tally;
}

void add_scene(const RigidScene& scene, const ShakingHand& hand, const Tally& tally,
               const Rows& all) {
  Rows rows = all.of("rigid, " + scene.name);
  const auto count = static_cast<double>(tally.cpu.count());
  rows.add(
      {{"triangles of the object", scene.object.mesh.triangles.size()},
       {"triangles of the tool", scene.tool.mesh.triangles.size()},
       {"frames of 1 kHz", count},
       {"speed of the hand, max", hand.top_speed(), "m/s"},
       {"updates a second of CPU time", 1e9 * count / tally.cpu_ns, "Hz", at_least(kGoalRate)}});
  const auto seconds = [](int64_t ns) { return 1e-9 * static_cast<double>(ns); };
  const double p50 = seconds(tally.cpu.percentile(50));
  rows.add({{"one move, CPU p50", p50, "s"},
            {"one move, CPU p99", seconds(tally.cpu.percentile(99)), "s"},
            {"one move, CPU longest", seconds(tally.cpu.max()), "s"},
            {"the first, from home to the hand, CPU", 1e-9 * tally.first_ns, "s"}});
  rows.add("one move, on the clock", tally.clock);
  rows.add({{"frames held back by contacts", tally.pressed / count},
            {"contacts, mean", tally.contacts / count},
            {"settled frames held back without a contact", tally.blind, "", kMustBeZero},
            {"poses judged exactly", tally.exact},
            {"of them inside or meeting", tally.entered, "", kMustBeZero},
            {"others that may meet", tally.met, "", kMustBeZero},
            {"frames unsettled", tally.unsettled / count},
            {"settled frames judged by all pairs", tally.rests},
            {"of them not to be judged", tally.unknown},
            {"of them jams", tally.jams, "", kMustBeZero},
            {"longest way left there", tally.longest, "m"}});
  if (tally.peer.empty()) {
    rows.note("FCL", kLeftOut);
  } else {
    rows.add_beside("one move, CPU p50, beside", p50, "s", "FCL, one distance at the same poses",
                    percentile(tally.peer, 50));
  }
}

void all_rows(const Options& options, const Rows& all) {
  Rows rows = all.machine("rigid");
  uint64_t seed = options.seed;
  const auto run = [&](const RigidScene& scene) {
    const ShakingHand hand(scene.home, scene.shaking, seed++);
    add_scene(scene, hand, shake(scene, hand, options), all);
  };
  for (const std::string& name : options.scenes) {
    if (name == "peg") run(peg_in_hole(kClearance));
    if (name == "bolt") run(bolt_in_nut());
    if (name != "bunny") continue;
    const std::optional<RigidScene> bunny = bunny_on_bunny(options.meshes);
    if (bunny) {
      run(*bunny);
    } else {
      rows.note("bunny on bunny", "LEFT OUT: no bunny00.off in '" + options.meshes +
                                      "'; give its folder with --meshes");
    }
  }
}

}  // namespace

/// The 6-DoF god-object while a hand shakes it against walls at 1 kHz: times of a move, and that no
/// verified pose is ever inside or held back without contact. FCL's distance at the same poses for
/// comparison.
Measured bench_rigid(Command& command) {
  const auto options = std::make_shared<Options>();
  options->meshes = meshes_folder();
  command.option("--scene SCENE", options->scenes, "bunny, peg or bolt; several may be given")
      .one_of({"bunny", "peg", "bolt"});
  add_counts(command,
             {{"--frames", &options->frames, "of 1 kHz, in each scene", 1, 100'000'000},
              {"--exact", &options->exact, "poses checked exactly, at most", 1, 100'000'000},
              {"--rests", &options->rests, "settled poses checked with all pairs, at most", 1,
               100'000'000}});
  command.option("--seed", options->seed, "of the hands").show_default();
  command.option("--meshes FOLDER", options->meshes, "folder with bunny00.off").show_default();
  return measured(all_rows, options);
}

}  // namespace haptic
