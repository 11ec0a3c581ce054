// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/supervisor.h"

#include <poll.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstring>
#include <span>
#include <string_view>
#include <utility>

#include "proto/ipc/process.h"
#include "proto/ipc/sessions.h"
#include "proto/math/units.h"
#include "proto/os/priorities.h"
#include "proto/os/realtime.h"
#include "servo/hapticd/child_process.h"

namespace haptic {
namespace {

constexpr int64_t kLookPeriodNs = 20 * kMs;  // of events and heartbeats
constexpr int64_t kLongestRestNs = 5 * kMs;  // a tenth of the restart of a contact

/// The stop signals are read from a descriptor from now on.
FileDescriptor take_signals() {
  const sigset_t set = stop_signals();
  sigprocmask(SIG_BLOCK, &set, nullptr);
  signal(SIGPIPE, SIG_IGN);
  // ignored by the parent, deaths of children would leave nothing to wait for
  signal(SIGCHLD, SIG_DFL);
  return FileDescriptor(signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK));
}

}  // namespace

Supervisor::Supervisor(std::vector<SessionConfig> hands, std::string config_text,
                       const std::string& session, HapticdLog& log)
    : session_{std::move(hands), std::move(config_text), session, log},
      signals_(take_signals()),
      attachments_(connect_session(session), {.on_error =
                                                  [&log](const std::string& what) {
                                                    log.write(LogLevel::kError, "hapticd", what);
                                                  }}),
      children_(session_, attachments_),
      commands_(session_, attachments_, children_) {
  if (session_.config.n_clients > 0) givers_.emplace(session, session_.config);
  commands_.show_givers(givers_ ? &*givers_ : nullptr);
}

int Supervisor::run() {
  // the first hand's last: a child that has it has all there are
  for (uint32_t hand = static_cast<uint32_t>(session_.hands.size()); hand-- > 0;) {
    DesiredState& desired = session_.desired[hand];
    desired.segment.set_state(SegmentState::kRun);
    desired.publish(now_ns());
    const SegmentSpec spec = segment_spec<ControlChannels>(hand);
    session_.server.announce(spec.id, 1, spec.name, desired.segment.fd());
  }
  attachments_.start();
  children_.guard_devices();
  if (session_.config.realtime != 0) {
    enter_realtime({.fifo_priority = kHousekeepingPriority, .lock_memory = false});
  }
  children_.start();
  session_.log.write(LogLevel::kInfo, "hapticd",
                     "session runs at " + session_.server.socket_path());
  int64_t next_look_ns = now_ns();
  while (!session_.exit_code) {
    const int64_t woke_ns = wait_for_work(next_look_ns);
    children_.reap([this](uint32_t hand) { commands_.keep_fault(hand); });
    const int64_t t_ns = now_ns();
    children_.start_due(t_ns);
    commands_.turn(t_ns);
    if (t_ns >= next_look_ns) {
      children_.look(t_ns, t_ns - next_look_ns);
      commands_.look(t_ns);
      watch_place();
      session_.log.drain();
      next_look_ns = t_ns + kLookPeriodNs;
    }
    // leaves half of a processor to lower priorities, whatever the load of requests, and sleeps
    // often enough not to be throttled as a runaway real-time thread
    const int64_t done_ns = now_ns();
    sleep_until(done_ns + std::min(done_ns - woke_ns, kLongestRestNs));
  }
  children_.stop();
  // watchers see by this that nobody has killed it
  for (DesiredState& desired : session_.desired) desired.segment.set_state(SegmentState::kDead);
  return *session_.exit_code;
}

/// Waits, and passes on what has come. Returns when it woke.
int64_t Supervisor::wait_for_work(int64_t until_ns) {
  constexpr size_t kOwn = 4;
  std::array<pollfd, kOwn + Children::kWaits> waiting{
      {{session_.server.poll_fd(), POLLIN, 0},
       {signals_.get(), POLLIN, 0},
       {commands_.poll_fd(), POLLIN, 0},
       {givers_ ? givers_->poll_fd() : -1, POLLIN, 0}}};
  const int64_t next_start_ns = children_.wait_for(std::span(waiting).subspan<kOwn>());
  until_ns = std::min({until_ns, next_start_ns, commands_.next_turn_ns()});
  poll(waiting.data(), waiting.size(), poll_ms(until_ns));
  const int64_t woke_ns = now_ns();
  children_.write_output();
  session_.server.serve([this](const Announcement& offer, int) { children_.take_offer(offer); },
                        [this](std::string_view line) { return commands_.answer_watcher(line); });
  commands_.serve();
  serve_givers();
  signalfd_siginfo info;
  if (read(signals_.get(), &info, sizeof info) == sizeof info) {
    session_.log.write(LogLevel::kInfo, "hapticd",
                       std::string("stopping: ") + strsignal(static_cast<int>(info.ssi_signo)));
    session_.end(kExitClean);
  }
  return woke_ns;
}

/// What a client offers goes to all that attach segments, as what a child offers.
void Supervisor::serve_givers() {
  if (!givers_) return;
  const GiveServer::Handlers handlers{.on_offer =
                                          [this](const Announcement& offer, int fd) {
                                            session_.server.announce(offer.id, offer.generation,
                                                                     offer.name.data(), fd);
                                          },
                                      .say =
                                          [this](const std::string& line) {
                                            session_.log.write(LogLevel::kInfo, "hapticd", line);
                                          }};
  givers_->serve(now_ns(), handlers);
  const auto before = session_.desired[kFirstHand].frame.giving;
  auto giving = before;
  for (uint32_t c = 0; c < giving.size(); ++c) {
    giving[c] = givers_->giving(c);
    // its memory is large; a drawing of the next one comes a turn after its first segment
    if (giving[c] != before[c]) session_.server.withdraw(DrawChannels::id(c));
  }
  if (giving == before) return;
  // sim and the contacts listen to nobody else
  for (DesiredState& desired : session_.desired) {
    desired.frame.giving = giving;
    desired.publish(now_ns());
  }
}

/// A session that cannot be reached cannot be stopped either, so it ends.
void Supervisor::watch_place() {
  try {
    const bool was_removed = session_.server.restore();
    commands_.restore();
    if (givers_) givers_->restore();
    if (was_removed) {
      session_.log.write(
          LogLevel::kWarning, "hapticd",
          "somebody removed " + session_.server.socket_path() + " or its lock: put back");
    }
  } catch (const HandoutError& error) {
    session_.log.write(
        LogLevel::kError, "hapticd",
        std::string("the session can no longer be reached and ends: ") + error.what());
    session_.end(kExitCrash);
  }
}

}  // namespace haptic
