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

using Hand = SessionStatus::Hand;

std::vector<std::string> closed_by(const Hand& hand) {
  if (!hand.runs)
    return {"the servo does not run (contact prepares the meshes first; see the log)"};
  return reasons_for_no_force(hand.servo);
}

std::string_view renderer_of(const Hand& hand) {
  return row_of(static_cast<Renderer>(hand.wanted.renderer)).name;
}

/// Names the solver of a renderer of a soft body; empty: there is none to choose.
std::string_view solver_name(const Hand& hand) {
  const auto solver = soft_solver_of(hand.wanted.solver);
  const Moves moves = row_of(static_cast<Renderer>(hand.wanted.renderer)).moves;
  if (!solver || moves != Moves::kSoftBody) return "";
  return kSoftSolverNames[static_cast<size_t>(*solver)];
}

bool is_led(const Hand& hand) {
  return hand.runs && (hand.servo.device.flags & kDeviceLed) != 0;
}

std::string hand_text(const Hand& hand) {
  const std::string_view solver = solver_name(hand);
  std::string text = fmt::format(
      "renderer   {}{}{}, stiffness {}\n", renderer_of(hand), solver.empty() ? "" : ", solver ",
      solver, quantity_text(hand.wanted.translational_stiffness, Dimension::kStiffness));
  text += fmt::format("device     {}\n", shown(hand.device));
  if (is_led(hand)) {
    const Vec3& p = hand.wanted.X_WT_intent.p;
    text += fmt::format("hand       led to ({:.4f}, {:.4f}, {:.4f}) m\n", p.x, p.y, p.z);
  }
  std::string force;
  for (const std::string& reason : closed_by(hand)) {
    force += (force.empty() ? "closed: " : "\n           closed: ") + reason;
  }
  text += fmt::format("force      {}\n", force.empty() ? "open" : force);
  return text +
         fmt::format("state      {}\n", hand.runs ? state_text(hand.servo.flags) : "unknown");
}

Json json_of(const Hand& hand) {
  const std::vector<std::string> closed = closed_by(hand);
  const std::string_view solver = solver_name(hand);
  return {{"renderer", renderer_of(hand)},
          {"device", hand.device},
          {"force", closed.empty() ? "open" : "closed"},
          {"closed_by", closed},
          {"state", words_of_flags(hand.servo.flags)},
          {"revision", hand.wanted.revision},
          {"armed", hand.wanted.armed != 0},
          {"paused", hand.wanted.paused != 0},
          {"stiffness", hand.wanted.translational_stiffness},
          {"solver", solver.empty() ? Json(nullptr) : Json(solver)},
          {"led", is_led(hand)},
          {"tick", hand.servo.tick},
          {"fault", hand.servo.fault}};
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
  for (const Hand& hand : status.hands) {
    if (status.hands.size() > 1) text += fmt::format("hand       {}\n", shown(hand.name));
    text += hand_text(hand);
  }
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
  Json hands = Json::array();
  for (const Hand& hand : status.hands) {
    hands.push_back(json_of(hand));
    hands.back()["name"] = hand.name;
  }
  // what is a hand's stands for the first beside the list of all
  Json line{{"session", status.session}, {"since", time_text("%Y-%m-%dT%H:%M:%S%z", status.since)}};
  line.update(json_of(status.hands.front()));
  line.update({{"hands", hands},
               {"processes", processes},
               {"spare",
                {{"pid", status.spare.pid},
                 {"generation", status.spare.generation},
                 {"ready", status.spare.is_ready}}},
               {"clients", status.clients},
               {"giving", givers},
               {"out_of_reach", status.gone.bodies},
               {"reach", status.gone.reach}});
  return json_line(line);
}

}  // namespace haptic
