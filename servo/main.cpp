// SPDX-License-Identifier: GPL-3.0-or-later
// haptic-servo: device, coupling, proxy solver and safety, once per period.
#include <cstdio>
#include <memory>
#include <string>

#include "proto/config/hand_config.h"
#include "proto/ipc/process.h"
#include "proto/os/message.h"
#include "proto/os/priorities.h"
#include "servo/loop.h"

namespace haptic {
namespace {

/// The servos of a session wake one after the other, spread over a period of the first hand's, on a
/// grid that all know: of this clock, whenever a servo starts.
int64_t first_tick_of(const SessionConfig& config, int64_t t_ns) {
  const int64_t period = period_ns(config.servo_rate);
  const int64_t offset = period * config.hand / config.n_hands;
  return (t_ns / period + 2) * period + offset;
}

int run(const ChildArguments& arguments) {
  Child<ServoChannels> child(arguments);
  const auto own = std::make_unique<const SessionConfig>(with_tools(child.hands(), child.hand()));
  const SessionConfig& config = *own;
  const auto inbox = std::make_unique<ServoInbox>(child, config);
  const std::unique_ptr<Device> device =
      open_device(config.device, FileDescriptor(arguments.device_fd));
  const auto loop = std::make_unique<ServoLoop>(config, *device, *inbox, child.channels());
  std::fprintf(stderr, "haptic-servo: device: %s\n",
               haptic::one_line(device->description()).c_str());
  if (config.map.grasp_button >= 0 && device->caps().causality == Causality::kAdmittance) {
    std::fprintf(stderr,
                 "%shaptic-servo: an admittance device grasps nothing; remove grasp_button from "
                 "[map]\n",
                 std::string(kWarningLine).c_str());
  }
  child.start({.fifo_priority = kServoPriority, .lock_memory = true});

  DeadlineClock clock(period_ns(config.servo_rate),
                      config.servo_wake == Wake::kHybrid ? kHybridSpinNs : 0);
  if (config.n_hands > 1) clock.start_at(first_tick_of(config, now_ns()));
  while (!child.stopping()) {
    const Tick tick = clock.wait();
    child.beat(tick);
    loop->tick(tick);
  }
  loop->stop();
  child.finish();
  return kExitClean;
}

}  // namespace
}  // namespace haptic

int main(int argc, char** argv) {
  return haptic::run_child(argc, argv, haptic::run);
}
