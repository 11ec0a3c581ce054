// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/commands.h"

#include <algorithm>
#include <limits>

#include "proto/config/devices.h"
#include "proto/ipc/process.h"
#include "proto/math/units.h"
#include "proto/os/message.h"
#include "servo/hapticd/command.h"

namespace haptic {
namespace {

constexpr int64_t kControlPeriodNs = 100 * kMs;  // a late reader of the ring soon finds a frame
constexpr int64_t kEchoPeriodNs = 2 * kMs;       // while a client waits for the servo's echo
constexpr int64_t kEchoPatienceNs = 1000 * kMs;  // until that client gets an error

}  // namespace

Commands::Commands(SessionRun& session, Attachments& attachments, Children& children)
    : session_(session),
      children_(children),
      socket_(session.name),
      leads_(session),
      servo_frames_(attachments.ring<&ServoChannels::frames>(Start::kNewest)),
      sim_frames_(attachments.ring<&SimChannels::frames>(Start::kNewest)),
      contact_sets_(attachments.ring<&ContactChannels::sets>(Start::kNewest)) {}

int64_t Commands::next_turn_ns() const {
  return unanswered_.empty() ? std::numeric_limits<int64_t>::max() : now_ns() + kEchoPeriodNs;
}

void Commands::serve() {
  socket_.serve([this](uint64_t peer, std::string_view line) { take(peer, line); });
}

void Commands::take(uint64_t peer, std::string_view line) {
  const ControlCommand command = apply_command(line, session_.config, session_.desired.frame);
  std::string answer = "ok";
  switch (command.kind) {
    case CommandKind::kQuestion:
      answer = command.answer(status(), session_.config_text);
      break;
    case CommandKind::kRefused:
      answer = one_line(std::string(kMistakeAnswer) + command.problem);
      break;
    case CommandKind::kStop:
      session_.log.write(LogLevel::kInfo, "hapticd", "stopping: asked to");
      session_.end(kExitClean);
      break;
    case CommandKind::kLead:
      // answered at once: it comes sixty times a second, and the next one corrects it
      leads_.take(line);
      break;
    case CommandKind::kChange:
      session_.log.write(LogLevel::kInfo, "hapticd",
                         std::string(line) + " (revision " +
                             std::to_string(session_.desired.frame.revision) + ")");
      session_.desired.publish(now_ns());
      unanswered_.push_back({peer, session_.desired.frame.revision, command.clears_fault,
                             now_ns() + kEchoPatienceNs,
                             command.warning.empty() ? "" : "; warning: " + command.warning});
      return;
  }
  socket_.answer(peer, answer);
}

std::string Commands::answer_watcher(std::string_view line) {
  if (line == "status") return status_json(status());
  return line == "status text" ? status_text(status()) : "";
}

void Commands::turn(int64_t t_ns) {
  servo_frames_.latest(servo_frame_);
  std::erase_if(unanswered_, [&](const Unanswered& asked) {
    const bool taken = servo_frame_.control_revision >= asked.revision;
    const bool done = taken && !(asked.clears_fault && servo_frame_.fault != 0);
    if (!done && t_ns < asked.give_up_ns) return false;
    socket_.answer(asked.peer,
                   done    ? "ok" + asked.warning
                   : taken ? "error: the fault is still there; hold the handle stiller than 0.1 "
                             "m/s (the request waits), see the log for its cause"
                           : "error: the servo did not apply it within a second (the request "
                             "waits); see hapt status");
    return true;
  });
  if (t_ns - session_.desired.frame.t_ns >= kControlPeriodNs) session_.desired.publish(t_ns);
}

void Commands::look(int64_t t_ns) {
  // frees the segments of those that have died
  sim_frames_.latest(scene_frame_);
  contact_sets_.latest(contact_set_);
  leads_.look(t_ns);
}

void Commands::keep_fault() {
  servo_frames_.latest(servo_frame_);
  if (servo_frame_.fault == 0) return;
  session_.desired.frame.fault = servo_frame_.fault;
  session_.desired.change(now_ns());
}

SessionStatus Commands::status() {
  servo_frames_.latest(servo_frame_);
  sim_frames_.latest(scene_frame_);
  contact_sets_.latest(contact_set_);
  SessionStatus status{
      .session = session_.name,
      .device = std::string(row_of(session_.config.device.kind).name),
      .since = since_,
      .now = std::time(nullptr),
      .processes = {},
      .spare = {},
      .clients = std::max<size_t>(session_.server.n_clients(), 1) - 1,  // but hapticd itself
      .wanted = session_.desired.frame,
      .servo = servo_frame_,
      .gone = out_of_reach(session_.config, scene_frame_),
      .givers = {}};
  children_.report(status);
  const std::array<std::span<const GiverState>, 2> taken{scene_frame_.givers, contact_set_.givers};
  for (uint32_t c = 0; givers_ != nullptr && c < session_.config.n_clients; ++c) {
    status.givers.push_back(giver_report(session_.config.clients[c], c, givers_->seat(c), taken));
  }
  return status;
}

}  // namespace haptic
