// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/status.h"

#include <spdlog/fmt/fmt.h>

#include "proto/config/quantity.h"
#include "proto/os/json.h"
#include "proto/os/message.h"
#include "proto/wire/renderer.h"
#include "servo/hapticd/state_words.h"

namespace haptic {
namespace {

std::string time_text(const char* format, std::time_t t) {
  char text[40];
  std::tm local{};
  localtime_r(&t, &local);
  return {text, std::strftime(text, sizeof text, format, &local)};
}

/// "95 s", "12 min", "3 h", "5 days".
std::string age_text(std::time_t seconds) {
  constexpr std::time_t kMinute = 60, kHour = 3600, kDay = 86400;
  if (seconds < 2 * kMinute) return fmt::format("{} s", seconds);
  if (seconds < 2 * kHour) return fmt::format("{} min", seconds / kMinute);
  if (seconds < 2 * kDay) return fmt::format("{} h", seconds / kHour);
  return fmt::format("{} days", seconds / kDay);
}

std::vector<std::string> closed_by(const SessionStatus& status) {
  const auto& servo = status.processes.back();
  if (!servo.runs)
    return {"the servo does not run (contact prepares the meshes first; see the log)"};
  return reasons_for_no_force(status.servo);
}

std::string_view renderer_of(const SessionStatus& status) {
  return row_of(static_cast<Renderer>(status.wanted.renderer)).name;
}

/// Names the solver of a renderer of a soft body; empty: there is none to choose.
std::string_view solver_name(const SessionStatus& status) {
  const auto solver = soft_solver_of(status.wanted.solver);
  const Moves moves = row_of(static_cast<Renderer>(status.wanted.renderer)).moves;
  if (!solver || moves != Moves::kSoftBody) return "";
  return kSoftSolverNames[static_cast<size_t>(*solver)];
}

bool is_led(const SessionStatus& status) {
  return status.processes.back().runs && (status.servo.device.flags & kDeviceLed) != 0;
}

std::string process_text(const SessionStatus::Process& process) {
  std::string text = process.name;
  if (!process.runs) text += " does not run";
  if (process.pid > 0) text += fmt::format(", pid {}", process.pid);
  if (process.generation > 1) text += fmt::format(", started {} times", process.generation);
  return text;
}

}  // namespace

std::string status_text(const SessionStatus& status) {
  std::string text = fmt::format("session    {}, since {} ({})\n", status.session,
                                 time_text("%Y-%m-%d %H:%M:%S", status.since),
                                 age_text(status.now - status.since));
  const std::string_view solver = solver_name(status);
  text += fmt::format("renderer   {}{}{}, stiffness {}\n", renderer_of(status),
                      solver.empty() ? "" : ", solver ", solver,
                      quantity_text(status.wanted.translational_stiffness, Dimension::kStiffness));
  text += fmt::format("device     {}\n", shown(status.device));
  if (is_led(status)) {
    const Vec3& p = status.wanted.X_WT_intent.p;
    text += fmt::format("hand       led to ({:.4f}, {:.4f}, {:.4f}) m\n", p.x, p.y, p.z);
  }
  std::string force;
  for (const std::string& reason : closed_by(status)) {
    force += (force.empty() ? "closed: " : "\n           closed: ") + reason;
  }
  text += fmt::format("force      {}\n", force.empty() ? "open" : force);
  const bool has_state = status.processes.back().runs;
  text += fmt::format("state      {}\n", has_state ? state_text(status.servo.flags) : "unknown");
  if (status.gone.bodies > 0) {
    text += fmt::format("scene      {}\n", out_of_reach_line(status.gone));
  }
  const char* head = "processes";
  for (const SessionStatus::Process& process : status.processes) {
    text += fmt::format("{:<9}  {}\n", head, process_text(process));
    head = "";
  }
  if (status.spare.pid > 0) {
    text += fmt::format("           spare contact, pid {}, {}\n", status.spare.pid,
                        status.spare.is_ready ? "ready" : "being prepared");
  }
  for (const GiverReport& giver : status.givers) {
    text += fmt::format("{:<9}  '{}' {}\n", &giver == status.givers.data() ? "giving" : "",
                        shown(giver.name), giver_text(giver));
  }
  return text + fmt::format("clients    {}", status.clients);
}

std::string status_json(const SessionStatus& status) {
  Json processes = Json::array();
  for (const SessionStatus::Process& process : status.processes) {
    processes.push_back({{"name", process.name},
                         {"pid", process.pid},
                         {"generation", process.generation},
                         {"runs", process.runs}});
  }
  Json givers = Json::array();
  for (const GiverReport& giver : status.givers) {
    givers.push_back({{"name", giver.name},
                      {"pid", giver.pid},
                      {"rate", giver.rate},
                      {"refused", giver.refused},
                      {"state", giver.words},
                      {"text", giver_text(giver)}});
  }
  const std::vector<std::string> closed = closed_by(status);
  const ControlFrame& wanted = status.wanted;
  const std::string_view solver = solver_name(status);
  return json_line({{"session", status.session},
                    {"since", time_text("%Y-%m-%dT%H:%M:%S%z", status.since)},
                    {"renderer", renderer_of(status)},
                    {"device", status.device},
                    {"force", closed.empty() ? "open" : "closed"},
                    {"closed_by", closed},
                    {"state", words_of_flags(status.servo.flags)},
                    {"processes", processes},
                    {"spare",
                     {{"pid", status.spare.pid},
                      {"generation", status.spare.generation},
                      {"ready", status.spare.is_ready}}},
                    {"clients", status.clients},
                    {"giving", givers},
                    {"revision", wanted.revision},
                    {"armed", wanted.armed != 0},
                    {"paused", wanted.paused != 0},
                    {"stiffness", wanted.translational_stiffness},
                    {"solver", solver.empty() ? Json(nullptr) : Json(solver)},
                    {"led", is_led(status)},
                    {"tick", status.servo.tick},
                    {"fault", status.servo.fault},
                    {"out_of_reach", status.gone.bodies},
                    {"reach", status.gone.reach}});
}

}  // namespace haptic
