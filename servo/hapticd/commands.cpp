// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/commands.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "proto/config/devices.h"
#include "proto/config/hand_config.h"
#include "proto/ipc/process.h"
#include "proto/math/units.h"
#include "proto/os/message.h"

namespace haptic {
namespace {

constexpr int64_t kControlPeriodNs = 100 * kMs;  // a late reader of the ring soon finds a frame
constexpr int64_t kEchoPeriodNs = 2 * kMs;       // while a client waits for the servo's echo

}  // namespace

Commands::Commands(SessionRun& session, Attachments& attachments, Children& children)
    : session_(session),
      children_(children),
      socket_(session.name),
      leads_(session),
      sim_frames_(attachments.ring<&SimChannels::frames>(Start::kNewest)) {
  for (const SessionConfig& config : session.hands) {
    heard_.push_back({attachments.ring<&ServoChannels::frames>(Start::kNewest, config.hand),
                      attachments.ring<&ContactChannels::sets>(Start::kNewest, config.hand)});
  }
}

int64_t Commands::next_turn_ns() const {
  return echoes_.any() ? now_ns() + kEchoPeriodNs : std::numeric_limits<int64_t>::max();
}

void Commands::serve() {
  socket_.serve([this](uint64_t peer, std::string_view line) { take(peer, line); });
}

void Commands::take(uint64_t peer, std::string_view line) {
  const AddressedLine to = read_address(line, session_.config);
  ControlCommand command{.problem = to.problem};
  std::vector<ControlFrame> wanted;
  for (const uint32_t hand : to.hands) {
    if (!to.problem.empty()) break;
    wanted.push_back(session_.desired[hand].frame);
    command = apply_command(to.line, session_.hands[hand], wanted.back());
    if (command.kind == CommandKind::kRefused) break;
  }
  if (command.kind == CommandKind::kLead && to.hands.size() > 1) {
    command = {.problem = "lead: name one hand of " + names_of_all_hands(session_.config) +
                          ", as --hand " + name_of_hand(session_.config, kFirstHand)};
  }
  switch (command.kind) {
    case CommandKind::kQuestion:
      return socket_.answer(peer, command.answer(status(), session_.config_text));
    case CommandKind::kRefused:
      return socket_.answer(peer, one_line(std::string(kMistakeAnswer) + command.problem));
    case CommandKind::kStop:
      session_.log.write(LogLevel::kInfo, "hapticd", "stopping: asked to");
      session_.end(kExitClean);
      return socket_.answer(peer, "ok");
    case CommandKind::kLead:
      session_.desired[to.hands.front()].frame = wanted.front();
      // answered at once: it comes sixty times a second, and the next one corrects it
      leads_.take(to.hands.front(), to.line);
      return socket_.answer(peer, "ok");
    case CommandKind::kChange:
      return change(peer, line, command, to.hands, wanted);
  }
}

/// Publishes what has changed; it is answered when the servos have echoed it.
void Commands::change(uint64_t peer, std::string_view line, const ControlCommand& command,
                      const std::vector<uint32_t>& hands, const std::vector<ControlFrame>& wanted) {
  Echoes::Change asked{.peer = peer,
                       .revisions = {},
                       .clears_fault = command.clears_fault,
                       .warning = command.warning};
  for (size_t k = 0; k < hands.size(); ++k) {
    session_.desired[hands[k]].frame = wanted[k];
    asked.revisions.push_back({hands[k], wanted[k].revision});
  }
  for (DesiredState& desired : session_.desired) {
    // the scene is one for all
    desired.frame.scene_time_scale = wanted.back().scene_time_scale;
    desired.publish(now_ns());
  }
  session_.log.write(
      LogLevel::kInfo, "hapticd",
      std::string(line) + " (revision " + std::to_string(wanted.back().revision) + ")");
  echoes_.await(std::move(asked), now_ns());
}

std::string Commands::answer_watcher(std::string_view line) {
  if (line == "status") return status_json(status());
  return line == "status text" ? status_text(status()) : "";
}

void Commands::turn(int64_t t_ns) {
  for (Heard& heard : heard_) heard.servo_frames.latest(heard.servo);
  echoes_.answer(
      t_ns, [this](uint32_t hand) -> const ServoFrame& { return heard_[hand].servo; },
      [this](uint64_t peer, const std::string& text) { socket_.answer(peer, text); });
  for (DesiredState& desired : session_.desired) {
    if (t_ns - desired.frame.t_ns >= kControlPeriodNs) desired.publish(t_ns);
  }
}

void Commands::look(int64_t t_ns) {
  // frees the segments of those that have died
  sim_frames_.latest(scene_frame_);
  for (Heard& heard : heard_) heard.contact_sets.latest(heard.contact);
  leads_.look(t_ns);
}

void Commands::keep_fault(uint32_t hand) {
  Heard& heard = heard_[hand];
  heard.servo_frames.latest(heard.servo);
  if (heard.servo.fault == 0) return;
  session_.desired[hand].frame.fault = heard.servo.fault;
  session_.desired[hand].change(now_ns());
}

SessionStatus Commands::status() {
  sim_frames_.latest(scene_frame_);
  SessionStatus status{
      .session = session_.name,
      .since = since_,
      .now = std::time(nullptr),
      .hands = {},
      .processes = {},
      .spare = {},
      .clients = std::max<size_t>(session_.server.n_clients(), 1) - 1,  // but hapticd itself
      .gone = out_of_reach(session_.config, scene_frame_),
      .givers = {}};
  std::vector<std::span<const GiverState>> taken{scene_frame_.givers};
  for (const SessionConfig& config : session_.hands) {
    Heard& heard = heard_[config.hand];
    heard.servo_frames.latest(heard.servo);
    heard.contact_sets.latest(heard.contact);
    status.hands.push_back({.name = name_of_hand(config, config.hand),
                            .device = std::string(row_of(config.device.kind).name),
                            .wanted = session_.desired[config.hand].frame,
                            .servo = heard.servo});
    taken.emplace_back(heard.contact.givers);
  }
  children_.report(status);
  for (uint32_t c = 0; givers_ != nullptr && c < session_.config.n_clients; ++c) {
    status.givers.push_back(giver_report(session_.config.clients[c], c, givers_->seat(c), taken));
  }
  return status;
}

}  // namespace haptic
