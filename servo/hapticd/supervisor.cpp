// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/supervisor.h"

#include <poll.h>
#include <sys/signalfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <limits>
#include <span>
#include <stdexcept>

#include "proto/config/devices.h"
#include "proto/ipc/control.h"
#include "proto/ipc/process.h"
#include "proto/ipc/sessions.h"
#include "proto/math/units.h"
#include "proto/os/message.h"
#include "proto/os/programs.h"
#include "proto/os/realtime.h"
#include "proto/os/source_tree.h"
#include "servo/hapticd/command.h"

namespace haptic {
namespace {

constexpr int64_t kLookPeriodNs = 20 * kMs;       // of events and heartbeats
constexpr int64_t kControlPeriodNs = 100 * kMs;   // a late reader of the ring soon finds a frame
constexpr int64_t kTellWaitingNs = 10'000 * kMs;  // between log lines before the first contact
constexpr int64_t kEchoPeriodNs = 2 * kMs;        // while a client waits for the servo's echo
constexpr int64_t kEchoPatienceNs = 1000 * kMs;   // until that client gets an error
constexpr int64_t kServoStopNs = 1000 * kMs;      // for the servo alone, part of kStopNs
constexpr int64_t kStopNs = 2000 * kMs;           // then children are killed
constexpr int64_t kLongestRestNs = 5 * kMs;       // a tenth of the restart of a contact
constexpr int64_t kRetryStartNs = 500 * kMs;      // if the kernel has no resources for a process
constexpr int64_t kSpareAfterNs = 500 * kMs;  // after contact's start, when its meshes are baked
constexpr HandNames kSpareNames = names_of_hands("contact", " spare");
constexpr const char* kSpareName = kSpareNames[kFirstHand].data();
constexpr int kMostDeathsUnborn = 8;  // about five seconds of attempts

/// The stop signals are read from a descriptor from now on.
FileDescriptor take_signals() {
  const sigset_t set = stop_signals();
  sigprocmask(SIG_BLOCK, &set, nullptr);
  signal(SIGPIPE, SIG_IGN);
  return FileDescriptor(signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK));
}

}  // namespace

Supervisor::Supervisor(const SessionConfig& config, std::string config_text,
                       const std::string& session, HapticdLog& log)
    : config_(config),
      config_text_(std::move(config_text)),
      session_(session),
      log_(log),
      folder_(program_folder()),
      server_(session),
      commands_(session),
      config_file_(make_sealed_file("haptic-config", std::as_bytes(std::span(&config_, 1)))),
      signals_(take_signals()),
      control_frame_(initial_control(config)),
      processes_{{{"haptic-sim", SimChannels::kId, SimChannels::kName, period_ns(config.sim_rate)},
                  {"haptic-contact", ContactChannels::kId, ContactChannels::kName,
                   period_ns(config.contact_poll_rate)},
                  {"haptic-servo", ServoChannels::kId, ServoChannels::kName,
                   period_ns(config.servo_rate)}}},
      spare_(config.contact_spare != 0),
      attachments_(connect_session(session), {.on_error =
                                                  [&log](const std::string& what) {
                                                    log.write(LogLevel::kError, "hapticd", what);
                                                  }}),
      sim_events_(attachments_.ring<&SimChannels::events>(Start::kOldest)),
      contact_events_(attachments_.ring<&ContactChannels::events>(Start::kOldest)),
      servo_events_(attachments_.ring<&ServoChannels::events>(Start::kOldest)),
      servo_frames_(attachments_.ring<&ServoChannels::frames>(Start::kNewest)),
      sim_frames_(attachments_.ring<&SimChannels::frames>(Start::kNewest)) {
  if (row_of(config.device.kind).has_node()) guard_.emplace(config, attachments_);
  for (const Process& process : processes_) {
    const std::string path = folder_ + "/" + process.program;
    if (access(path.c_str(), X_OK) != 0) throw std::runtime_error(cannot_start(path, errno));
  }
}

Supervisor::~Supervisor() {
  stop_children();
}

int Supervisor::run() {
  control_.set_state(SegmentState::kRun);
  publish_control(now_ns());
  server_.announce(ControlChannels::kId, 1, ControlChannels::kName, control_.fd());
  attachments_.start();
  if (guard_) guard_->start();
  if (config_.realtime != 0) {
    enter_realtime({.fifo_priority = kHousekeepingPriority, .lock_memory = false});
  }
  // the servo comes last: a hand must not enter an object whose mesh is still being read
  Process& servo = processes_.back();
  for (Process& process : processes_) {
    if (&process != &servo) start(process);
  }
  servo.restart_at_ns = std::numeric_limits<int64_t>::max();
  told_waiting_ns_ = now_ns();
  log_.write(LogLevel::kInfo, "hapticd", "session runs at " + server_.socket_path());

  int64_t next_look_ns = now_ns();
  int64_t next_control_ns = next_look_ns + kControlPeriodNs;
  while (!stopping_) {
    wait_for_work(next_look_ns);
    for (Process& process : processes_) reap(process);
    const int64_t t_ns = now_ns();
    restart_due(t_ns);
    answer_commands(t_ns);
    if (t_ns >= next_control_ns) {
      publish_control(t_ns);
      next_control_ns = t_ns + kControlPeriodNs;
    }
    if (t_ns >= next_look_ns) {
      write_events();
      sim_frames_.latest(scene_frame_);  // frees the segments of sims that have died
      for (Process& process : processes_) watch_pulse(process, t_ns, t_ns - next_look_ns);
      watch_spare(t_ns);
      watch_lead(t_ns);
      watch_device(t_ns);
      watch_place();
      tell_waiting(t_ns);
      log_.drain();
      next_look_ns = t_ns + kLookPeriodNs;
    }
    rest();
  }
  stop_children();
  write_events();
  // watchers see by this that nobody has killed it
  control_.set_state(SegmentState::kDead);
  return exit_code_;
}

/// Leaves half of a processor to lower priorities, whatever the load of requests, and sleeps often
/// enough not to be throttled as a runaway real-time thread.
void Supervisor::rest() const {
  const int64_t t_ns = now_ns();
  sleep_until(t_ns + std::min(t_ns - woke_ns_, kLongestRestNs));
}

void Supervisor::wait_for_work(int64_t until_ns) {
  std::array<pollfd, 11> waiting{};
  waiting[0] = {server_.poll_fd(), POLLIN, 0};
  waiting[1] = {signals_.get(), POLLIN, 0};
  waiting[2] = {commands_.poll_fd(), POLLIN, 0};
  // poll ignores the −1 of a process that does not run
  const auto wait_for = [&](size_t i, const ChildProcess& child) {
    waiting[3 + 2 * i] = {child.pidfd.get(), POLLIN, 0};
    waiting[4 + 2 * i] = {child.output_fd(), POLLIN, 0};
  };
  for (size_t i = 0; i < processes_.size(); ++i) {
    wait_for(i, processes_[i].child);
    until_ns = std::min(until_ns, start_time(processes_[i]));
  }
  wait_for(processes_.size(), spare_.process);
  if (!unanswered_.empty()) until_ns = std::min(until_ns, now_ns() + kEchoPeriodNs);
  const int64_t left_ns = std::max<int64_t>(until_ns - now_ns(), 0);
  poll(waiting.data(), waiting.size(), static_cast<int>((left_ns + kMs - 1) / kMs));
  woke_ns_ = now_ns();
  for (Process& process : processes_) write_output(process.name, process.child, false);
  write_output(kSpareName, spare_.process, false);
  server_.serve([this](const Announcement& a, int) { take_offer(a); },
                [this](std::string_view line) { return answer_watcher(line); });
  commands_.serve([this](uint64_t peer, std::string_view line) { take_command(peer, line); });
  signalfd_siginfo info;
  if (read(signals_.get(), &info, sizeof info) == sizeof info) {
    log_.write(LogLevel::kInfo, "hapticd",
               std::string("stopping: ") + strsignal(static_cast<int>(info.ssi_signo)));
    stopping_ = true;
  }
}

void Supervisor::take_offer(const Announcement& offer) {
  for (Process& process : processes_) {
    if (process.id == offer.id) process.offered_generation = offer.generation;
  }
  Process& servo = processes_.back();
  if (offer.id != ContactChannels::kId) return;
  if (servo.generation == 0) servo.restart_at_ns = 0;
  spare_.wait_until(now_ns() + kSpareAfterNs);
}

void Supervisor::write_output(const char* name, ChildProcess& child, bool ended) {
  if (!child.output) return;
  const auto use = [&](const std::string& line) {
    if (line.starts_with(kPreparing)) child.preparing = line.substr(kPreparing.size());
    const auto [level, text] = level_of_line(line);
    log_.write(level, name, std::string(text));
  };
  ended ? child.output->flush(use) : child.output->read(use);
}

void Supervisor::take_command(uint64_t peer, std::string_view line) {
  const bool was_leading = control_frame_.leading != 0;
  const ControlCommand command = apply_command(line, config_, control_frame_);
  switch (command.kind) {
    case CommandKind::kStatusText:
      commands_.answer(peer, status_text(status()));
      break;
    case CommandKind::kRefused:
      commands_.answer(peer, one_line(std::string(kMistakeAnswer) + command.problem));
      break;
    case CommandKind::kStatus:
      commands_.answer(peer, status_json(status()));
      break;
    case CommandKind::kConfig:
      commands_.answer(peer, config_text_);
      break;
    case CommandKind::kStop:
      log_.write(LogLevel::kInfo, "hapticd", "stopping: asked to");
      commands_.answer(peer, "ok");
      stopping_ = true;
      break;
    case CommandKind::kLead:
      lead(peer, line, was_leading);
      break;
    case CommandKind::kChange:
      log_.write(LogLevel::kInfo, "hapticd",
                 std::string(line) + " (revision " + std::to_string(control_frame_.revision) + ")");
      publish_control(now_ns());
      unanswered_.push_back({peer, control_frame_.revision, command.clears_fault,
                             now_ns() + kEchoPatienceNs,
                             command.warning.empty() ? "" : "; warning: " + command.warning});
  }
}

/// Answered at once: it comes sixty times a second, and the next one corrects it.
void Supervisor::lead(uint64_t peer, std::string_view line, bool was_leading) {
  const bool leads = control_frame_.leading != 0;
  if (leads) control_frame_.intent_t_ns = now_ns();
  publish_control(now_ns());
  commands_.answer(peer, "ok");
  if (leads != was_leading) {
    log_.write(LogLevel::kInfo, "hapticd",
               leads ? "somebody leads the hand: " + std::string(line) : "nobody leads the hand");
  }
}

/// The servo does not wait for this; it keeps the desired state true for those who watch.
void Supervisor::watch_lead(int64_t t_ns) {
  if (control_frame_.leading == 0 || t_ns <= control_frame_.intent_t_ns + kLeadNs) return;
  control_frame_.leading = 0;
  ++control_frame_.revision;
  publish_control(t_ns);
  log_.write(LogLevel::kInfo, "hapticd", "nobody leads the hand any more: no command for 200 ms");
}

/// Everybody who may watch may ask for the status, and for nothing else.
std::string Supervisor::answer_watcher(std::string_view line) {
  if (line == "status") return status_json(status());
  return line == "status text" ? status_text(status()) : "";
}

/// A change is acknowledged only when a servo frame carries its revision.
void Supervisor::answer_commands(int64_t t_ns) {
  servo_frames_.latest(servo_frame_);
  std::erase_if(unanswered_, [&](const Unanswered& asked) {
    const bool taken = servo_frame_.control_revision >= asked.revision;
    const bool done = taken && !(asked.clears_fault && servo_frame_.fault != 0);
    if (!done && t_ns < asked.give_up_ns) return false;
    commands_.answer(asked.peer,
                     done    ? "ok" + asked.warning
                     : taken ? "error: the fault is still there; hold the handle stiller than 0.1 "
                               "m/s (the request waits), see the log for its cause"
                             : "error: the servo did not apply it within a second (the request "
                               "waits); see hapt status");
    return true;
  });
}

SessionStatus Supervisor::status() {
  servo_frames_.latest(servo_frame_);
  sim_frames_.latest(scene_frame_);
  SessionStatus status;
  status.session = session_;
  status.device = std::string(row_of(config_.device.kind).name);
  if (guard_) status.device += " at " + guard_->path();
  status.since = since_;
  status.now = std::time(nullptr);
  for (const Process& process : processes_) {
    const SegmentHeader* header = header_of(process);
    const bool runs = process.child.is_running() && header != nullptr &&
                      header->generation.load() == process.generation &&
                      header->state.load() == static_cast<uint32_t>(SegmentState::kRun);
    status.processes.push_back({process.name, process.child.pid, process.generation, runs});
  }
  status.spare = {spare_.process.pid, spare_.generation, spare_.is_ready()};
  status.clients = std::max<size_t>(server_.n_clients(), 1) - 1;  // but hapticd itself
  status.wanted = control_frame_;
  status.servo = servo_frame_;
  status.gone = out_of_reach(config_, scene_frame_);
  return status;
}

/// Preparing a mesh may take minutes: tells the operator what the session waits for.
void Supervisor::tell_waiting(int64_t t_ns) {
  if (processes_.back().generation > 0 || t_ns - told_waiting_ns_ < kTellWaitingNs) return;
  told_waiting_ns_ = t_ns;
  log_.write(LogLevel::kInfo, "hapticd",
             std::string("the servo waits until ") + contact_.name + " has prepared its meshes");
}

void Supervisor::launch(const Process& process, uint64_t generation, ChildProcess& child,
                        int spare_fd) {
  const FileDescriptor socket = server_.connect_child(process.id, generation);
  std::vector<std::string> words;
  std::vector<int> kept;
  const auto hand_over = [&](const char* key, int fd) {
    words.insert(words.end(), {key, std::to_string(fd)});
    kept.push_back(fd);
  };
  hand_over("--config-fd", config_file_.get());
  hand_over("--control-fd", socket.get());
  if (drives(process)) hand_over("--device-fd", guard_->node_for_servo());
  if (spare_fd >= 0) hand_over("--spare-fd", spare_fd);
  words.insert(words.end(), {"--generation", std::to_string(generation)});
  child.launch(folder_, process.program, std::move(words), kept);
}

void Supervisor::start(Process& process) {
  if (&process == &contact_) reap_spare();
  if (&process == &contact_ && spare_.process.is_running()) {
    promote_spare(process);
  } else {
    process.generation = ++process.last_generation;
    launch(process, process.generation, process.child);
    process.was_ready = false;
  }
  server_.forget_children(process.id, process.generation);
  process.started_ns = now_ns();
  process.pulse = Pulse::kFine;
  process.silence = {};
  if (drives(process)) guard_->watch(process.child.pidfd.get(), process.generation);
}

/// Call it only once contact is dead and reaped, so that there is one writer.
void Supervisor::promote_spare(Process& contact) {
  contact.generation = spare_.generation;
  contact.was_ready = spare_.is_ready();
  contact.child = spare_.promote();
}

void Supervisor::reap_spare() {
  const auto status = spare_.process.ended();
  if (!status) return;
  write_output(kSpareName, spare_.process, true);
  const int64_t wait_ns = spare_.put_off(now_ns());
  log_.write(LogLevel::kWarning, kSpareName,
             std::string(contact_.program) + " " + how_it_ended(*status, "") +
                 " while it waited; another one in " + std::to_string(wait_ns / kMs) + " ms");
}

/// Keeps a spare beside a running contact and replaces it when it dies.
void Supervisor::watch_spare(int64_t t_ns) {
  reap_spare();
  const bool contact_runs =
      contact_.child.is_running() && contact_.offered_generation == contact_.generation;
  if (!contact_runs || !spare_.is_due(t_ns)) return;
  try {
    const FileDescriptor turn = spare_.connect(t_ns);
    spare_.generation = ++contact_.last_generation;
    launch(contact_, spare_.generation, spare_.process, turn.get());
  } catch (const std::exception& error) {
    log_.write(LogLevel::kError, kSpareName,
               std::string("cannot be started: ") + error.what() + "; trying again in " +
                   std::to_string(spare_.put_off(t_ns) / kMs) + " ms");
  }
}

/// Whether starting it again cannot help; logs why.
bool Supervisor::is_hopeless(Process& process, int status) {
  const SegmentHeader* header = header_of(process);
  const bool ran = header != nullptr && header->generation.load() == process.generation &&
                   header->state.load() != static_cast<uint32_t>(SegmentState::kInit);
  process.ever_ran |= ran;
  if (ran) process.child.preparing.clear();
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 0;
  // waits for a device that was there, as long as it takes
  if (code == kExitNoDevice && process.ever_ran) return false;
  if (code == kExitBadInput || code == kExitNoDevice || code == kExitNoProgram) {
    log_.write(LogLevel::kError, process.name,
               std::string(process.program) +
                   " cannot run with this input, for the reason above; the session ends");
    exit_code_ = kExitBadInput;
    return true;
  }
  // a mesh prepared once is in the cache, so the next attempt may succeed
  if (!process.child.preparing.empty() && !process.ever_ran) {
    log_.write(
        LogLevel::kError, process.name,
        std::string(process.program) + " " + how_it_ended(status, process.child.preparing) +
            "; the session ends; try that mesh alone (hapt bake), repair or decimate it; the "
            "kernel kills what takes more memory than there is");
    exit_code_ = kExitCrash;
    return true;
  }
  // what has run with this input may run again, however often it is killed
  process.deaths_unborn = process.ever_ran ? 0 : process.deaths_unborn + 1;
  if (process.deaths_unborn < kMostDeathsUnborn) return false;
  log_.write(LogLevel::kError, process.name,
             std::string(process.program) + " " + how_it_ended(status, process.child.preparing) +
                 " " + std::to_string(kMostDeathsUnborn) +
                 " times before it ran; the session ends; look for the reason above");
  exit_code_ = kExitCrash;
  return true;
}

void Supervisor::reap(Process& process) {
  const auto ended = process.child.ended();
  if (!ended) return;
  const int status = *ended;
  write_output(process.name, process.child, true);
  if (is_hopeless(process, status)) {
    stopping_ = true;
    return;
  }
  const int64_t t_ns = now_ns();
  if (t_ns - process.started_ns >= kHealthyNs) process.deaths_in_a_row = 0;
  const int64_t delay_ns = restart_delay_ns(++process.deaths_in_a_row, t_ns - process.started_ns);
  process.restart_at_ns = t_ns + delay_ns;
  if (process.id == ServoChannels::kId) keep_fault();
  log_.write(LogLevel::kWarning, process.name,
             std::string(process.program) + " " + how_it_ended(status, process.child.preparing) +
                 "; starting it again " +
                 (lacks_device(process) ? "when the device is back"
                                        : "in " + std::to_string(delay_ns / kMs) + " ms"));
}

void Supervisor::restart_due(int64_t t_ns) {
  for (Process& process : processes_) {
    if (stopping_ || t_ns < start_time(process)) continue;
    try {
      start(process);
    } catch (const std::exception& error) {
      // a lack of descriptors or memory may pass; the session waits
      process.restart_at_ns = t_ns + kRetryStartNs;
      log_.write(LogLevel::kError, process.name,
                 std::string(process.program) + " cannot be started: " + error.what() +
                     "; trying again in " + std::to_string(kRetryStartNs / kMs) + " ms");
    }
  }
}

/// When to start a process; never while it runs or its device is gone.
int64_t Supervisor::start_time(const Process& process) const {
  const bool waits = !process.child.is_running() && !lacks_device(process);
  return waits ? process.restart_at_ns : std::numeric_limits<int64_t>::max();
}

/// A fault outlives the servo that found it, until it is cleared.
void Supervisor::keep_fault() {
  servo_frames_.latest(servo_frame_);
  if (servo_frame_.fault == 0) return;
  control_frame_.fault = servo_frame_.fault;
  ++control_frame_.revision;
  publish_control(now_ns());
}

/// Waits for a device that is gone; its return gets a new servo that initialises it.
void Supervisor::watch_device(int64_t t_ns) {
  if (!guard_) return;
  Process& servo = processes_.back();
  const DeviceGuard::Change change = guard_->look(t_ns);
  if (change == DeviceGuard::Change::kGone) {
    log_.write(LogLevel::kWarning, servo.name,
               guard_->path() + ": the device is gone; plug it in again, the session waits");
  } else if (change == DeviceGuard::Change::kBack) {
    log_.write(LogLevel::kInfo, servo.name, guard_->path() + ": the device is back");
    servo.child.send(SIGTERM);
  }
  if (guard_->releases() == told_releases_) return;
  told_releases_ = guard_->releases();
  log_.write(LogLevel::kWarning, servo.name, "does not answer: hapticd has let go of the device");
}

/// A session that cannot be reached cannot be stopped either, so it ends.
void Supervisor::watch_place() {
  try {
    const bool was_removed = server_.restore();
    commands_.restore();
    if (was_removed) {
      log_.write(LogLevel::kWarning, "hapticd",
                 "somebody removed " + server_.socket_path() + " or its lock: put back");
    }
  } catch (const HandoutError& error) {
    log_.write(LogLevel::kError, "hapticd",
               std::string("the session can no longer be reached and ends: ") + error.what());
    exit_code_ = kExitCrash;
    stopping_ = true;
  }
}

void Supervisor::publish_control(int64_t t_ns) {
  control_frame_.t_ns = t_ns;
  control_.channels().frames.publish(control_frame_);
  control_.beat(control_.channels().frames.published(), t_ns);
}

const SegmentHeader* Supervisor::header_of(const Process& process) noexcept {
  if (process.id == SimChannels::kId) return sim_events_.header();
  if (process.id == ContactChannels::kId) return contact_events_.header();
  return servo_events_.header();
}

/// Time without a heartbeat, where one is expected, else 0 [ns].
int64_t Supervisor::silence_of(Process& process, int64_t t_ns, int64_t held_up_ns) {
  if (!process.child.is_running()) return 0;
  if (process.offered_generation != process.generation) {
    // it may bake or home for long; only a ready spare is expected to be quick
    return process.was_ready ? process.silence.look(0, process.started_ns, t_ns, held_up_ns) : 0;
  }
  const SegmentHeader* header = header_of(process);
  const bool expected = header != nullptr && header->generation.load() == process.generation &&
                        header->state.load() == static_cast<uint32_t>(SegmentState::kRun);
  if (!expected) return 0;
  return process.silence.look(header->heartbeat.load(), header->heartbeat_ns.load(), t_ns,
                              held_up_ns);
}

void Supervisor::watch_pulse(Process& process, int64_t t_ns, int64_t held_up_ns) {
  const int64_t silent_ns = silence_of(process, t_ns, held_up_ns);
  const Pulse pulse = judge_pulse(silent_ns, process.period_ns);
  // one line when the state gets worse, not one per check
  if (pulse > process.pulse) {
    const bool hung = pulse == Pulse::kHung;
    log_.write(hung ? LogLevel::kError : LogLevel::kWarning, process.name,
               std::string(hung ? "hangs: " : "late: ") + "no cycle for " +
                   std::to_string(silent_ns / kMs) + " ms" + (hung ? "; killed" : ""));
    if (hung) process.child.send(SIGKILL);
  }
  process.pulse = pulse;
}

template <typename Events>
void Supervisor::write_events_of(const char* name, Events& events, uint64_t& lost) {
  for (Event event; events.next(event);) log_.write_event(name, event);
  if (events.lost() != lost) {
    log_.write(LogLevel::kWarning, name,
               std::to_string(events.lost() - lost) + " events came too fast to be written");
    lost = events.lost();
  }
}

void Supervisor::write_events() {
  write_events_of(processes_[0].name, sim_events_, lost_events_[0]);
  write_events_of(processes_[1].name, contact_events_, lost_events_[1]);
  write_events_of(processes_[2].name, servo_events_, lost_events_[2]);
}

void Supervisor::stop_child(const char* name, const char* program, ChildProcess& child,
                            int64_t deadline_ns) {
  if (!child.wait_for_exit(deadline_ns)) {
    log_.write(LogLevel::kWarning, name,
               std::string(program) + " did not stop in time and is killed");
    child.end();
  }
  write_output(name, child, true);
}

void Supervisor::stop_children() {
  const int64_t begin_ns = now_ns();
  // the servo first: it writes the zero wrench while contact and sim still answer
  ChildProcess& servo = processes_.back().child;
  servo.send(SIGTERM);
  servo.wait_for_exit(begin_ns + kServoStopNs);
  for (const Process& process : processes_) process.child.send(SIGTERM);
  spare_.process.send(SIGTERM);
  for (Process& process : processes_) {
    stop_child(process.name, process.program, process.child, begin_ns + kStopNs);
  }
  stop_child(kSpareName, contact_.program, spare_.process, begin_ns + kStopNs);
}

}  // namespace haptic
