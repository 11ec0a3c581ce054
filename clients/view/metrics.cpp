// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/view/metrics.h"

#include <cmath>

#include "proto/os/text.h"

namespace haptic {
namespace {

std::string number(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "+Inf" : "-Inf";
  return formatted("%.17g", value);
}

/// The lines of all metrics; a metric's name holds its unit.
class Exposition {
 public:
  void head(const std::string& name, const char* type, const char* help) {
    text_ += "# HELP " + name + " " + help + "\n# TYPE " + name + " " + type + "\n";
  }
  void line(const std::string& name, double value) { text_ += name + " " + number(value) + "\n"; }

  void gauge(const std::string& name, const char* help, double value) {
    head(name, "gauge", help);
    line(name, value);
  }
  void counter(const std::string& name, const char* help, uint64_t value) {
    head(name, "counter", help);
    line(name, static_cast<double>(value));
  }
  void summary(const std::string& name, const char* help, const DurationSum& sum) {
    head(name, "summary", help);
    line(name + "_sum", sum.sum);
    line(name + "_count", static_cast<double>(sum.count));
  }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

void add_servo(Exposition& out, const View& view) {
  out.counter("haptic_servo_ticks_total", "Servo frames that the bridge has seen or counted.",
              view.ticks);
  out.counter("haptic_servo_lost_total", "Of them overwritten before the bridge read them.",
              view.lost);
  out.counter("haptic_servo_skipped_ticks_total", "Ticks that the servo has skipped.",
              view.servo.skipped);
  out.gauge("haptic_servo_rate_hertz", "Servo frames a second.", view.rate_servo);
  out.summary("haptic_servo_busy_seconds", "From wake-up to force sent.", view.busy);
  out.summary("haptic_servo_wake_lateness_seconds", "Wake-up after the deadline.", view.wake_late);
  out.gauge("haptic_servo_age_seconds", "Since the newest servo frame.",
            age_of(view, view.has_servo, view.servo.t_ns));
  out.gauge("haptic_servo_flags", "Flags of the newest servo frame (ServoFlag).", view.servo.flags);
  out.gauge("haptic_servo_fault", "Latched fault (Fault); 0: none.", view.servo.fault);
  out.counter("haptic_servo_faults_total", "Faults latched since the bridge began.", view.faults);
  out.gauge("haptic_force_newtons", "Force at the device.", norm(view.servo.F_device_B.f));
  out.gauge("haptic_torque_newton_metres", "Torque at the device.", norm(view.servo.F_device_B.t));
  out.gauge("haptic_depth_metres", "From tool to proxy.", view.servo.depth);
}

void add_others(Exposition& out, const View& view) {
  out.gauge("haptic_contact_rate_hertz", "Answers of contact a second.", view.rate_contact);
  out.summary("haptic_contact_busy_seconds", "Of an answer of contact that the bridge read.",
              view.contact_busy);
  out.gauge("haptic_contact_age_seconds", "Since the tick that the newest answer is for.",
            age_of(view, view.has_contacts, view.contacts.answers_t_ns));
  out.gauge("haptic_sim_rate_hertz", "Scene frames a second.", view.rate_sim);
  out.gauge("haptic_sim_age_seconds", "Since the newest scene frame.",
            age_of(view, view.has_scene, view.scene.t_ns));
  out.head("haptic_process_restarts_total", "counter", "Starts of a process after its first.");
  for (const ProcessView& process : view.processes) {
    if (process.generation == 0) continue;
    out.line("haptic_process_restarts_total{process=\"" + std::string(process.name) + "\"}",
             static_cast<double>(process.generation - 1));
  }
}

}  // namespace

std::string metrics_text(const View& view, const BridgeCounts& counts, bool is_connected) {
  Exposition out;
  out.gauge("haptic_session_up", "1 where the bridge is connected to hapticd.", is_connected);
  add_servo(out, view);
  add_others(out, view);
  out.gauge("haptic_view_viewers", "Pages and Foxglove clients that watch.",
            static_cast<double>(counts.viewers));
  out.gauge("haptic_view_connections", "Connections of all kinds.",
            static_cast<double>(counts.connections));
  out.counter("haptic_view_frames_sent_total", "Frames sent to pages.", counts.frames_sent);
  out.counter("haptic_view_frames_skipped_total", "Frames that a page was not ready for in time.",
              counts.frames_skipped);
  out.counter("haptic_view_reconnects_total", "Connections to a hapticd that was started again.",
              counts.reconnects);
  return out.take();
}

}  // namespace haptic
