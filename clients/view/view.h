// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "clients/log/samples.h"
#include "proto/wire/wire.h"

namespace haptic {

/// A process of a session, as its segment shows it.
struct ProcessView {
  const char* name = "";
  uint64_t pid = 0, generation = 0;  // 0: not seen yet
  bool runs = false;
  double age = 0;   // of its heartbeat [s]
  double rate = 0;  // records a second
};

/// Sum and count of a duration over all ticks [s].
struct DurationSum {
  double sum = 0;
  uint64_t count = 0;
};

/// Everything that is to be seen at one instant, whether it comes from a running session or from a
/// log: plain data, from which frames, messages and metrics are made.
struct View {
  bool has_servo = false, has_contacts = false, has_scene = false, has_control = false;
  ServoFrame servo{};
  ContactSet contacts{};
  SceneFrame scene{};
  ControlFrame control{};
  Samples samples;
  Pose X_WB;               // base of the device in the scene
  uint32_t solver = 0;     // SoftSolver of the session
  double tick_period = 0;  // [s]; 0: not known yet
  int64_t now_ns = 0;      // CLOCK_MONOTONIC of this view
  uint64_t ticks = 0;      // servo frames since the source began, lost ones included
  uint64_t lost = 0;       // of them overwritten before they were read
  double rate_servo = 0, rate_contact = 0, rate_sim = 0;  // [Hz]
  DurationSum wake_late, busy, contact_busy;
  uint64_t faults = 0;                     // latched since the source began
  uint64_t drawn = 0;                      // how often what clients draw has changed
  std::array<ProcessView, 4> processes{};  // servo, contact, sim, control
};

/// The soft solver, whether the hand is led by a viewer, and where it means to go: as the session
/// says it, where it does.
uint32_t solver_of(const View& view);
bool is_led(const View& view);
Vec3 intent_of(const View& view);

/// Age of what happened at t_ns, in seconds; NaN where it has not (`has` is false).
double age_of(const View& view, bool has, int64_t t_ns);

/// How often a counter advances, over about a second.
class RateMeter {
 public:
  /// The counter at t_ns; one that falls begins anew (its writer was replaced).
  void add(int64_t t_ns, uint64_t count);
  /// [Hz]; 0 before it is known.
  double rate() const;

 private:
  struct Mark {
    int64_t t_ns = 0;
    uint64_t count = 0;
  };
  std::vector<Mark> marks_;
};

}  // namespace haptic
