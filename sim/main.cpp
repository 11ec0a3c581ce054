// SPDX-License-Identifier: GPL-3.0-or-later
// haptic-sim: moves the scene and publishes the poses of the objects.
#include <memory>

#include "proto/ipc/process.h"
#include "sim/step.h"

namespace haptic {
namespace {

constexpr int64_t kPatienceNs = kNsPerSecond;  // longest wait for the predecessor's frames
constexpr int64_t kLookNs = 1'000'000;         // between checks

/// After a restart: the predecessor's last frame. hapticd announces in order, so once our own
/// segment arrives there is nothing older to wait for.
bool last_frame_before(RingSource<&SimChannels::frames>& frames, uint64_t own_generation,
                       SceneFrame& last) {
  const int64_t give_up_ns = now_ns() + kPatienceNs;
  bool found = false;
  while (now_ns() < give_up_ns) {
    found |= frames.latest(last);
    if (frames.generation() == own_generation) break;
    sleep_until(now_ns() + kLookNs);
  }
  return found;
}

int run(const ChildArguments& arguments) {
  Child<SimChannels> child(arguments);
  auto predecessors = child.ring<&SimChannels::frames>(Start::kOldest);
  auto controls = child.ring<&ControlChannels::frames>(Start::kOldest);
  const SimModel model = build_sim(child.config());
  const auto state = std::make_unique<SimState>();
  child.start({.fifo_priority = 0, .lock_memory = false});

  SceneFrame frame{};
  if (child.generation() > 1 && last_frame_before(predecessors, child.generation(), frame)) {
    resume(model, *state, frame);
  }
  ControlFrame control{};
  control.scene_time_scale = 1;
  DeadlineClock clock(period_ns(child.config().sim_rate));
  while (!child.stopping()) {
    const Tick tick = clock.wait();
    child.beat(tick);
    controls.latest(control);
    // a ring may hold anything
    const double time_scale = control.scene_time_scale >= 0 ? control.scene_time_scale : 0;
    frame = sim_step(model, *state, tick.deadline_ns, time_scale);
    frame.busy_ns = now_ns() - tick.deadline_ns - tick.late_ns;
    child.channels().frames.publish(frame);
  }
  child.finish();
  return kExitClean;
}

}  // namespace
}  // namespace haptic

int main(int argc, char** argv) {
  return haptic::run_child(argc, argv, haptic::run);
}
