// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/view/metrics.h"

#include <cmath>
#include <initializer_list>

#include "proto/os/text.h"

namespace haptic {
namespace {

std::string number(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "+Inf" : "-Inf";
  return formatted("%.17g", value);
}

/// One metric, whose name holds its unit; that of a duration is a sum over all ticks.
struct Metric {
  const char *name, *type, *help;
  double value = 0;
  const DurationSum* sum = nullptr;
};

std::string line(const std::string& name, double value) {
  return name + " " + number(value) + "\n";
}

std::string head(const Metric& m) {
  const std::string name = m.name;
  return "# HELP " + name + " " + m.help + "\n# TYPE " + name + " " + m.type + "\n";
}

std::string lines_of(std::initializer_list<Metric> metrics) {
  std::string text;
  for (const Metric& m : metrics) {
    const std::string name = m.name;
    text +=
        head(m) + (m.sum == nullptr ? line(name, m.value)
                                    : line(name + "_sum", m.sum->sum) +
                                          line(name + "_count", static_cast<double>(m.sum->count)));
  }
  return text;
}

constexpr const char *kGauge = "gauge", *kCounter = "counter", *kSummary = "summary";

std::string servo_lines(const View& view) {
  const auto count = [](uint64_t n) { return static_cast<double>(n); };
  const ServoFrame& servo = view.servo;
  return lines_of(
      {{"haptic_servo_ticks_total", kCounter, "Servo frames that the bridge has seen or counted.",
        count(view.ticks)},
       {"haptic_servo_lost_total", kCounter, "Of them overwritten before the bridge read them.",
        count(view.lost)},
       {"haptic_servo_skipped_ticks_total", kCounter, "Ticks that the servo has skipped.",
        count(servo.skipped)},
       {"haptic_servo_rate_hertz", kGauge, "Servo frames a second.", view.rate_servo},
       {"haptic_servo_busy_seconds", kSummary, "From wake-up to force sent.", 0, &view.busy},
       {"haptic_servo_wake_lateness_seconds", kSummary, "Wake-up after the deadline.", 0,
        &view.wake_late},
       {"haptic_servo_age_seconds", kGauge, "Since the newest servo frame.",
        age_of(view, view.has_servo, servo.t_ns)},
       {"haptic_servo_flags", kGauge, "Flags of the newest servo frame (ServoFlag).",
        count(servo.flags)},
       {"haptic_servo_fault", kGauge, "Latched fault (Fault); 0: none.", count(servo.fault)},
       {"haptic_servo_faults_total", kCounter, "Faults latched since the bridge began.",
        count(view.faults)},
       {"haptic_force_newtons", kGauge, "Force at the device.", norm(servo.F_device_B.f)},
       {"haptic_torque_newton_metres", kGauge, "Torque at the device.", norm(servo.F_device_B.t)},
       {"haptic_depth_metres", kGauge, "From tool to proxy.", servo.depth}});
}

std::string process_lines(const View& view) {
  constexpr Metric kRestarts{"haptic_process_restarts_total", kCounter,
                             "Starts of a process after its first."};
  std::string text = lines_of(
      {{"haptic_contact_rate_hertz", kGauge, "Answers of contact a second.", view.rate_contact},
       {"haptic_contact_busy_seconds", kSummary, "Of an answer of contact that the bridge read.", 0,
        &view.contact_busy},
       {"haptic_contact_age_seconds", kGauge, "Since the tick that the newest answer is for.",
        age_of(view, view.has_contacts, view.contacts.answers_t_ns)},
       {"haptic_sim_rate_hertz", kGauge, "Scene frames a second.", view.rate_sim},
       {"haptic_sim_age_seconds", kGauge, "Since the newest scene frame.",
        age_of(view, view.has_scene, view.scene.t_ns)}});
  text += head(kRestarts);
  for (const ProcessView& process : view.processes) {
    if (process.generation == 0) continue;
    text += line(std::string(kRestarts.name) + "{process=\"" + process.name + "\"}",
                 static_cast<double>(process.generation - 1));
  }
  return text;
}

}  // namespace

std::string metrics_text(const View& view, const BridgeCounts& counts, bool is_connected) {
  const auto count = [](uint64_t n) { return static_cast<double>(n); };
  return lines_of({{"haptic_session_up", kGauge, "1 where the bridge is connected to hapticd.",
                    is_connected ? 1.0 : 0.0}}) +
         servo_lines(view) + process_lines(view) +
         lines_of({{"haptic_view_viewers", kGauge, "Pages and Foxglove clients that watch.",
                    count(counts.viewers)},
                   {"haptic_view_connections", kGauge, "Connections of all kinds.",
                    count(counts.connections)},
                   {"haptic_view_frames_sent_total", kCounter, "Frames sent to pages.",
                    count(counts.frames_sent)},
                   {"haptic_view_frames_skipped_total", kCounter,
                    "Frames that a page was not ready for in time.", count(counts.frames_skipped)},
                   {"haptic_view_reconnects_total", kCounter,
                    "Connections to a hapticd that was started again.", count(counts.reconnects)}});
}

}  // namespace haptic
