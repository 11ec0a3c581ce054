// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/measurement.h"

#include <limits>
#include <memory>

#include "clients/lab/eval/mesh/renderer.h"
#include "clients/lab/eval/scenes/workload.h"
#include "clients/lab/selftest/rt_guard.h"
#include "clients/lab/support/scripted_hand.h"
#include "clients/lab/support/thread_cpu.h"
#include "clients/library/histogram.h"
#include "proto/config/command_line.h"
#include "proto/os/progress.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

constexpr size_t kJudgedFrom = 1'000'000;  // triangles; the goals apply to the finest meshes
constexpr double kGoalP50 = 2e-6, kGoalP99 = 10e-6, kGoalMax = 25e-6;  // for a point [s]
constexpr double kSmallSphere = 1e-3;                                  // [m]
constexpr double kGoalSmallP99 = 50e-6, kGoalLargeP99 = 100e-6;        // for spheres [s]
constexpr int kEmptyMeasurements = 10'000;  // for the cost of reading the clock

struct Options {
  std::vector<std::string> meshes{"hf:50",     "hf:187",    "hf:374",     "hf:742",
                                  "sphere:16", "sphere:59", "sphere:118", "sphere:235"};
  std::vector<double> radii{0, 1e-3, 5e-3};  // of the proxy; the path keeps its depth [m]
  int repetitions = 5;                       // of the same path; the fastest of each tick counts
  int ticks = kEvalTicks;
};

/// Duration of an empty measurement, subtracted from each [ns].
int64_t clock_cost_ns() {
  int64_t least = std::numeric_limits<int64_t>::max();
  for (int i = 0; i < kEmptyMeasurements; ++i) {
    least = std::min(least, cpu_ns_of([] {}));
  }
  return least;
}

/// The servo's frames along the path, one per tick.
std::vector<ServoFrame> questions(const ToolPath& path, int ticks) {
  std::vector<ServoFrame> frames(static_cast<size_t>(ticks));
  ScriptedHand hand(path);
  for (size_t k = 0; k < frames.size(); ++k) {
    ServoFrame& frame = frames[k];
    frame.tick = k;
    frame.t_ns = 1'000'000 * static_cast<int64_t>(k + 1);
    hand.read({frame.t_ns, frame.t_ns}, frame.device);
    frame.X_WT = frame.device.X_BH;
    frame.V_WT = frame.device.V_BH;
    frame.flags = kServoNoContactSet;
    frame.renderer = static_cast<uint32_t>(Renderer::kVirtualProxy3);
  }
  return frames;
}

/// Prevents the compiler from removing an unused answer.
void keep(const ContactSet& set) {
  asm volatile("" : : "g"(&set) : "memory");
}

void add_time(Rows& rows, const Histogram& times, double radius, bool judged) {
  const auto seconds = [](int64_t ns) { return 1e-9 * static_cast<double>(ns); };
  const double sphere_p99 = radius > kSmallSphere ? kGoalLargeP99 : kGoalSmallP99;
  const bool point = radius == 0, point_judged = judged && point;
  rows.add({{"contact step, CPU p50", seconds(times.percentile(50)), "s",
             at_most(goal_if(point_judged, kGoalP50))},
            {"contact step, CPU p99", seconds(times.percentile(99)), "s",
             at_most(goal_if(judged, point ? kGoalP99 : sphere_p99))},
            {"contact step, CPU max", seconds(times.max()), "s",
             at_most(goal_if(point_judged, kGoalMax))}});
}

/// The least time of each step over the repetitions.
Histogram time_steps(const ContactModel& model, std::span<const ServoFrame> frames,
                     int repetitions) {
  const int64_t empty_ns = clock_cost_ns();
  std::vector<int64_t> least(frames.size(), std::numeric_limits<int64_t>::max());
  Progress progress("contact steps", repetitions);
  for (int r = 0; r < repetitions; ++r) {
    progress.at(r);
    const auto state = std::make_unique<ContactState>(model);
    for (size_t k = 0; k < frames.size(); ++k) {
      const auto step = [&] { keep(contact_step(model, *state, frames[k], nullptr)); };
      least[k] = std::min(least[k], cpu_ns_of(step));
    }
  }
  Histogram times;
  for (const int64_t ns : least) times.add(std::max<int64_t>(ns - empty_ns, 0));
  return times;
}

/// Observations of one further pass under rt_guard.
struct Watched {
  uint64_t allocated = 0;  // and freed
  uint64_t limited = 0;    // steps cut short
  uint64_t truncated = 0;  // answers that did not fit into the set
  size_t most_contacts = 0;
};

Watched watch_steps(const ContactModel& model, std::span<const ServoFrame> frames) {
  Watched watched;
  const auto state = std::make_unique<ContactState>(model);
  watched.allocated = allocations_of([&] {
    for (const ServoFrame& frame : frames) {
      const ContactSet set = contact_step(model, *state, frame, nullptr);
      watched.limited += (set.flags & kContactIterationLimit) != 0;
      watched.truncated += (set.flags & kContactTruncated) != 0;
      watched.most_contacts = std::max(watched.most_contacts, set.contacts.size());
    }
  });
  return watched;
}

void bench_one(const std::string& name, const MeshShape& shape, double radius,
               const Options& options, const Rows& all) {
  const ToolPath path = make_eval_work(name, radius).path;
  const std::vector<ServoFrame> frames = questions(path, options.ticks);
  SessionConfig config = plain_session(1000);
  config.proxy_radius = radius;
  const ContactModel model = build_contact_model(config, std::span(&shape, 1));
  const Histogram times = time_steps(model, frames, options.repetitions);
  const Watched watched = watch_steps(model, frames);

  Rows rows = all.of("virtual-proxy3, radius " + readable(radius, "m") + ", on " + name);
  const size_t triangles = shape.mesh.triangles.size();
  rows.add({{"work", name + ", radius " + readable(radius, "m")}, {"triangles", triangles}});
  add_time(rows, times, radius, triangles >= kJudgedFrom);
  rows.add({{"contacts, most in a step", watched.most_contacts},
            {"steps cut short", watched.limited},
            {"answers truncated", watched.truncated},
            {"allocations", watched.allocated, "", kMustBeZero}});
}

void all_rows(const Options& options, const Rows& all) {
  all.machine("point-proxy");
  for (const std::string& name : options.meshes) {
    const MeshShapeData mesh = build_shape(make_eval_work(name, 0).soup);
    for (const double radius : options.radii) {
      bench_one(name, mesh.view(), radius, options, all);
    }
  }
}

}  // namespace

/// Cost of a whole contact step of virtual-proxy3 on the benchmark set: CPU time of the thread
/// (CLOCK_THREAD_CPUTIME_ID minus the cost of reading it) of each tick, the least of the
/// repetitions, which excludes disturbances by the machine. One further pass reports what rt_guard
/// catches and how many contacts there are.
Measured bench_point_proxy(Command& command) {
  const auto options = std::make_shared<Options>();
  command.option("--mesh", options->meshes, "hf:N, sphere:N or flat:N; several may be given")
      .check([](const std::string& name) {
        return is_eval_work(name) ? "" : "give " + eval_work_names();
      });
  command
      .quantity("--radius", options->radii, Dimension::kLength, {0, 0.05},
                "of the proxy, as often as wanted; a number alone: metres", "m")
      .show_default();
  add_counts(command,
             {{"--repetitions", &options->repetitions, "the fastest of each tick counts", 1, 100}});
  return measured(all_rows, options);
}

}  // namespace haptic
