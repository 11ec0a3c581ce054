// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/bench_point_proxy.h"

#include <ctime>
#include <memory>

#include "clients/eval_renderer.h"
#include "clients/histogram.h"
#include "clients/scripted_hand.h"
#include "proto/rt_guard.h"

namespace haptic {
namespace {

constexpr size_t kJudgedFrom = 1'000'000;  // triangles: the goals are for the finest meshes
constexpr double kGoalP50 = 2e-6, kGoalP99 = 10e-6, kGoalMax = 25e-6;  // [s]

int64_t thread_cpu_ns() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return t.tv_sec * 1'000'000'000 + t.tv_nsec;
}

/// What the servo asks, tick by tick, along the path.
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
  }
  return frames;
}

/// Keeps an answer that nobody reads.
void keep(const ContactSet& set) {
  asm volatile("" : : "g"(&set) : "memory");
}

void add_time(Rows& rows, const Histogram& times, bool judged) {
  const auto add = [&](const char* metric, int64_t ns, double goal) {
    const double seconds = 1e-9 * static_cast<double>(ns);
    rows.add_if(judged, metric, seconds, "s", goal, seconds <= goal);
  };
  add("contact step, CPU p50", times.percentile(50), kGoalP50);
  add("contact step, CPU p99", times.percentile(99), kGoalP99);
  add("contact step, CPU max", times.max(), kGoalMax);
}

std::vector<Row> bench_one(const std::string& name, const BenchPointProxyOptions& options) {
  EvalWork work = make_eval_work(name, 0);
  const std::vector<ServoFrame> frames = questions(work.path, options.ticks);
  const MeshShapeData mesh = build_shape(std::move(work.soup));
  const MeshShape shape = mesh.view();
  const std::span<const MeshShape> shapes(&shape, 1);
  const ContactModel model = build_contact_model(plain_session(1000), shapes);
  std::vector<int64_t> least(frames.size(), std::numeric_limits<int64_t>::max());
  for (int r = 0; r < options.repetitions; ++r) {
    const auto state = std::make_unique<ContactState>();
    for (size_t k = 0; k < frames.size(); ++k) {
      const int64_t begin = thread_cpu_ns();
      keep(contact_step(model, *state, frames[k], nullptr));
      least[k] = std::min(least[k], thread_cpu_ns() - begin);
    }
  }
  Histogram times;
  for (const int64_t ns : least) times.add(ns);

  const auto state = std::make_unique<ContactState>();
  RtGuard guard({.filter_system_calls = false});
  guard.arm();
  for (const ServoFrame& frame : frames) keep(contact_step(model, *state, frame, nullptr));
  guard.disarm();
  const uint64_t allocated =
      guard.report().of(Violation::kAllocate).count + guard.report().of(Violation::kFree).count;

  Rows rows("god-object3 on " + name);
  const size_t triangles = shape.mesh.triangles.size();
  rows.add("triangles", static_cast<double>(triangles), "");
  add_time(rows, times, triangles >= kJudgedFrom);
  rows.add("allocations", static_cast<double>(allocated), "", 0, allocated == 0);
  return rows.rows();
}

}  // namespace

std::vector<Row> bench_point_proxy(const BenchPointProxyOptions& options) {
  Rows rows("point-proxy");
  rows.note("machine", machine_line());
  for (const std::string& name : options.meshes) rows.append(bench_one(name, options));
  return rows.rows();
}

}  // namespace haptic
