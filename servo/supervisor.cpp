// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/supervisor.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/signalfd.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <span>
#include <stdexcept>

#include "proto/control.h"
#include "proto/message.h"
#include "proto/process.h"
#include "proto/realtime.h"
#include "servo/command.h"

namespace haptic {
namespace {

constexpr int64_t kMs = 1'000'000;
constexpr int64_t kLookPeriodNs = 20 * kMs;       // events and pulses
constexpr int64_t kControlPeriodNs = 100 * kMs;   // a late reader of the ring finds one soon
constexpr int64_t kTellWaitingNs = 10'000 * kMs;  // while a hand waits for its first contact
constexpr int64_t kEchoPeriodNs = 2 * kMs;        // while somebody waits for the servo's echo
constexpr int64_t kEchoPatienceNs = 1000 * kMs;
constexpr int64_t kServoStopNs = 1000 * kMs;  // its share of the two seconds
constexpr int64_t kStopNs = 2000 * kMs;
constexpr int64_t kRetryStartNs = 500 * kMs;  // where the kernel has no room for a process
constexpr int kExitNoProgram = 127;
constexpr int kMostDeathsUnborn = 8;  // about five seconds of trying

sigset_t stop_signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&set, signal);
  return set;
}

/// From now on the signals are read from a descriptor.
FileDescriptor take_signals() {
  const sigset_t set = stop_signals();
  sigprocmask(SIG_BLOCK, &set, nullptr);
  signal(SIGPIPE, SIG_IGN);
  return FileDescriptor(signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK));
}

/// After fork: only calls that are safe in a copy of a process with threads.
[[noreturn]] void become(const char* path, char* const* argv, std::span<const int> kept, int said) {
  const sigset_t set = stop_signals();
  sigprocmask(SIG_UNBLOCK, &set, nullptr);
  signal(SIGPIPE, SIG_DFL);
  // own group: Ctrl-C reaches hapticd alone, which stops the servo first
  setpgid(0, 0);
  dup2(said, STDERR_FILENO);
  for (const int fd : kept) fcntl(fd, F_SETFD, 0);
  execv(path, argv);
  _exit(kExitNoProgram);
}

std::string how_it_ended(int status) {
  if (WIFSIGNALED(status)) return std::string("was killed: ") + strsignal(WTERMSIG(status));
  return "ended with exit code " + std::to_string(WEXITSTATUS(status));
}

}  // namespace

Supervisor::Supervisor(const SessionConfig& config, const std::string& session, HapticdLog& log)
    : config_(config),
      log_(log),
      folder_(program_folder()),
      server_(session),
      commands_(session),
      config_file_(make_sealed_file("haptic-config", std::as_bytes(std::span(&config_, 1)))),
      signals_(take_signals()),
      control_frame_(initial_control(config)),
      processes_{{{"haptic-sim", SegmentId::kSim, "sim", period_ns(config.sim_rate)},
                  {"haptic-contact", SegmentId::kContact0, "contact0",
                   period_ns(config.contact_poll_rate)},
                  {"haptic-servo", SegmentId::kServo0, "servo0", period_ns(config.servo_rate)}}},
      attachments_(connect_session(session), {.on_error =
                                                  [&log](const std::string& what) {
                                                    log.write(LogLevel::kError, "hapticd", what);
                                                  }}),
      sim_events_(attachments_.ring<&SimChannels::events>(Start::kOldest)),
      contact_events_(attachments_.ring<&ContactChannels::events>(Start::kOldest)),
      servo_events_(attachments_.ring<&ServoChannels::events>(Start::kOldest)),
      servo_frames_(attachments_.ring<&ServoChannels::frames>(Start::kNewest)) {
  if (config.device.kind == DeviceKind::kWoodenHaptics) guard_.emplace(config, attachments_);
  for (const Process& process : processes_) {
    const std::string path = folder_ + "/" + process.program;
    if (access(path.c_str(), X_OK) != 0) {
      throw std::runtime_error("cannot start " + path + ": " + std::strerror(errno) +
                               "; build it or set HAPTICD_LIBEXEC to its folder");
    }
  }
}

Supervisor::~Supervisor() {
  stop_children();
}

int Supervisor::run() {
  control_.set_state(SegmentState::kRun);
  publish_control(now_ns());
  server_.announce(SegmentId::kControl, 1, ControlChannels::kName, control_.fd());
  attachments_.start();
  if (guard_) guard_->start();
  // the servo last: a hand must not get inside an object while its mesh is still being read
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
      for (Process& process : processes_) watch_pulse(process, t_ns, t_ns - next_look_ns);
      watch_device(t_ns);
      watch_place();
      tell_waiting(t_ns);
      log_.drain();
      next_look_ns = t_ns + kLookPeriodNs;
    }
  }
  stop_children();
  write_events();
  return exit_code_;
}

void Supervisor::wait_for_work(int64_t until_ns) {
  std::array<pollfd, 9> waiting{};
  waiting[0] = {server_.poll_fd(), POLLIN, 0};
  waiting[1] = {signals_.get(), POLLIN, 0};
  for (size_t i = 0; i < processes_.size(); ++i) {
    // poll ignores the −1 of a process that does not run
    waiting[2 + i] = {processes_[i].pidfd.get(), POLLIN, 0};
    waiting[5 + i] = {processes_[i].output ? processes_[i].output->poll_fd() : -1, POLLIN, 0};
    until_ns = std::min(until_ns, start_time(processes_[i]));
  }
  waiting[8] = {commands_.poll_fd(), POLLIN, 0};
  if (!unanswered_.empty()) until_ns = std::min(until_ns, now_ns() + kEchoPeriodNs);
  const int64_t left_ns = std::max<int64_t>(until_ns - now_ns(), 0);
  poll(waiting.data(), waiting.size(), static_cast<int>((left_ns + kMs - 1) / kMs));
  for (Process& process : processes_) write_output(process, false);
  if (waiting[0].revents != 0) {
    server_.serve([this](const Announcement& offer, int) {
      Process& servo = processes_.back();
      if (offer.id == SegmentId::kContact0 && servo.generation == 0) servo.restart_at_ns = 0;
    });
  }
  commands_.serve([this](uint64_t peer, std::string_view line) { take_command(peer, line); });
  signalfd_siginfo info;
  if (read(signals_.get(), &info, sizeof info) == sizeof info) {
    log_.write(LogLevel::kInfo, "hapticd",
               std::string("stopping: ") + strsignal(static_cast<int>(info.ssi_signo)));
    stopping_ = true;
  }
}

void Supervisor::write_output(Process& process, bool ended) {
  if (!process.output) return;
  const auto use = [&](const std::string& line) {
    log_.write(LogLevel::kInfo, process.name, line);
  };
  ended ? process.output->flush(use) : process.output->read(use);
}

void Supervisor::take_command(uint64_t peer, std::string_view line) {
  const Command command = apply_command(line, config_, control_frame_);
  switch (command.kind) {
    case CommandKind::kRefused:
      commands_.answer(peer, one_line("error: " + command.problem));
      break;
    case CommandKind::kStatus:
      commands_.answer(peer, status());
      break;
    case CommandKind::kStop:
      log_.write(LogLevel::kInfo, "hapticd", "stopping: asked to");
      commands_.answer(peer, "ok");
      stopping_ = true;
      break;
    case CommandKind::kChange:
      log_.write(LogLevel::kInfo, "hapticd",
                 std::string(line) + " (revision " + std::to_string(control_frame_.revision) + ")");
      publish_control(now_ns());
      unanswered_.push_back(
          {peer, control_frame_.revision, command.clears_fault, now_ns() + kEchoPatienceNs});
  }
}

/// A change is acknowledged when a frame of the servo bears its revision, not before.
void Supervisor::answer_commands(int64_t t_ns) {
  servo_frames_.latest(servo_frame_);
  std::erase_if(unanswered_, [&](const Unanswered& asked) {
    const bool taken = servo_frame_.control_revision >= asked.revision;
    const bool done = taken && !(asked.clears_fault && servo_frame_.fault != 0);
    if (!done && t_ns < asked.give_up_ns) return false;
    commands_.answer(asked.peer,
                     done    ? "ok"
                     : taken ? "error: the fault is still there; hold the handle stiller than 0.1 "
                               "m/s (the request waits), see the log for its cause"
                             : "error: the servo has not taken it up within a second; see hapt "
                               "status, the request waits");
    return true;
  });
}

/// One line of JSON.
std::string Supervisor::status() noexcept {
  servo_frames_.latest(servo_frame_);
  std::string text = "{\"processes\": [";
  for (const Process& process : processes_) {
    const SegmentHeader* header = header_of(process);
    const bool runs = process.pid >= 0 && header != nullptr &&
                      header->generation.load() == process.generation &&
                      header->state.load() == static_cast<uint32_t>(SegmentState::kRun);
    text += std::string(&process == processes_.data() ? "" : ", ") + "{\"name\": \"" +
            process.name + "\", \"pid\": " + std::to_string(process.pid) +
            ", \"generation\": " + std::to_string(process.generation) +
            ", \"runs\": " + (runs ? "true" : "false") + "}";
  }
  return text + "], \"clients\": " + std::to_string(server_.n_clients()) +
         ", \"revision\": " + std::to_string(control_frame_.revision) +
         ", \"armed\": " + (control_frame_.armed != 0 ? "true" : "false") +
         ", \"paused\": " + (control_frame_.paused != 0 ? "true" : "false") +
         ", \"stiffness\": " + std::to_string(control_frame_.translational_stiffness) +
         ", \"tick\": " + std::to_string(servo_frame_.tick) +
         ", \"flags\": " + std::to_string(servo_frame_.flags) +
         ", \"fault\": " + std::to_string(servo_frame_.fault) + "}";
}

/// A mesh may take minutes to prepare: an operator should know what the hand waits for.
void Supervisor::tell_waiting(int64_t t_ns) {
  if (processes_.back().generation > 0 || t_ns - told_waiting_ns_ < kTellWaitingNs) return;
  told_waiting_ns_ = t_ns;
  log_.write(LogLevel::kInfo, "hapticd", "the servo waits until contact0 has prepared its meshes");
}

void Supervisor::start(Process& process) {
  ++process.generation;
  process.output.emplace(process.program);
  const FileDescriptor socket = server_.connect_child(process.id, process.generation);
  const std::string path = folder_ + "/" + process.program;
  std::vector<std::string> words{path,
                                 "--config-fd",
                                 std::to_string(config_file_.get()),
                                 "--control-fd",
                                 std::to_string(socket.get()),
                                 "--generation",
                                 std::to_string(process.generation)};
  std::vector<int> kept{config_file_.get(), socket.get()};
  if (drives(process)) {
    words.insert(words.end(), {"--device-fd", std::to_string(guard_->node())});
    kept.push_back(guard_->node());
  }
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  const pid_t pid = fork();
  if (pid == 0) become(path.c_str(), argv.data(), kept, process.output->child_end().get());
  if (pid < 0) throw std::runtime_error(std::string("cannot fork: ") + std::strerror(errno));
  process.output->child_end().reset();
  process.pid = pid;
  process.pidfd = FileDescriptor(static_cast<int>(syscall(SYS_pidfd_open, pid, 0)));
  process.started_ns = now_ns();
  process.pulse = Pulse::kFine;
  process.silence = {};
  if (drives(process)) guard_->watch(process.pidfd.get(), process.generation);
}

/// Whether starting it again cannot help; says why.
bool Supervisor::is_hopeless(Process& process, int status) {
  const SegmentHeader* header = header_of(process);
  const bool ran = header != nullptr && header->generation.load() == process.generation &&
                   header->state.load() != static_cast<uint32_t>(SegmentState::kInit);
  process.ever_ran |= ran;
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 0;
  // a device that was there is waited for, as long as it takes
  if (code == kExitNoDevice && process.ever_ran) return false;
  if (code == kExitBadInput || code == kExitNoDevice || code == kExitNoProgram) {
    log_.write(LogLevel::kError, process.name,
               std::string(process.program) +
                   " cannot run with this input, for the reason above; the session ends");
    exit_code_ = kExitBadInput;
    return true;
  }
  process.deaths_unborn = ran ? 0 : process.deaths_unborn + 1;
  if (process.deaths_unborn < kMostDeathsUnborn) return false;
  log_.write(LogLevel::kError, process.name,
             std::string(process.program) + " " + how_it_ended(status) + " " +
                 std::to_string(kMostDeathsUnborn) +
                 " times before it ran; the session ends; look for the reason above");
  exit_code_ = kExitCrash;
  return true;
}

void Supervisor::reap(Process& process) {
  int status = 0;
  if (process.pid < 0 || waitpid(process.pid, &status, WNOHANG) != process.pid) return;
  process.pid = -1;
  process.pidfd = {};
  write_output(process, true);
  if (is_hopeless(process, status)) {
    stopping_ = true;
    return;
  }
  const int64_t t_ns = now_ns();
  if (t_ns - process.started_ns >= kHealthyNs) process.deaths_in_a_row = 0;
  const int64_t delay_ns = restart_delay_ns(++process.deaths_in_a_row);
  process.restart_at_ns = t_ns + delay_ns;
  if (process.id == SegmentId::kServo0) keep_fault();
  log_.write(LogLevel::kWarning, process.name,
             std::string(process.program) + " " + how_it_ended(status) + "; starting it again " +
                 (lacks_device(process) ? "when the device is back"
                                        : "in " + std::to_string(delay_ns / kMs) + " ms"));
}

void Supervisor::restart_due(int64_t t_ns) {
  for (Process& process : processes_) {
    if (stopping_ || t_ns < start_time(process)) continue;
    try {
      start(process);
    } catch (const std::exception& error) {
      // no descriptor, no memory for a process: that may pass, and the session is worth waiting for
      process.output.reset();
      process.restart_at_ns = t_ns + kRetryStartNs;
      log_.write(LogLevel::kError, process.name,
                 std::string(process.program) + " cannot be started: " + error.what() +
                     "; trying again in " + std::to_string(kRetryStartNs / kMs) + " ms");
    }
  }
}

/// When a process is to be started; never while it runs, or waits for its device.
int64_t Supervisor::start_time(const Process& process) const {
  const bool waits = process.pid < 0 && !lacks_device(process);
  return waits ? process.restart_at_ns : std::numeric_limits<int64_t>::max();
}

/// A fault outlives the servo that found it, until somebody clears it.
void Supervisor::keep_fault() {
  servo_frames_.latest(servo_frame_);
  if (servo_frame_.fault == 0) return;
  control_frame_.fault = servo_frame_.fault;
  ++control_frame_.revision;
  publish_control(now_ns());
}

/// A device that went is waited for; one that comes back gets a servo that greets it anew.
void Supervisor::watch_device(int64_t t_ns) {
  if (!guard_) return;
  Process& servo = processes_.back();
  const DeviceGuard::Change change = guard_->look(t_ns);
  if (change == DeviceGuard::Change::kGone) {
    log_.write(LogLevel::kWarning, servo.name,
               guard_->path() + ": the device is gone; plug it in again, the session waits");
  } else if (change == DeviceGuard::Change::kBack) {
    log_.write(LogLevel::kInfo, servo.name, guard_->path() + ": the device is back");
    if (servo.pid >= 0) kill(servo.pid, SIGTERM);
  }
  if (guard_->releases() == told_releases_) return;
  told_releases_ = guard_->releases();
  log_.write(LogLevel::kWarning, servo.name, "does not answer: hapticd has let go of the device");
}

/// A session that nobody can reach any more cannot be stopped either.
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
  switch (process.id) {
    case SegmentId::kSim:
      return sim_events_.header();
    case SegmentId::kContact0:
      return contact_events_.header();
    default:
      return servo_events_.header();
  }
}

void Supervisor::watch_pulse(Process& process, int64_t t_ns, int64_t held_up_ns) {
  const SegmentHeader* header = header_of(process);
  // before its loop runs a process may bake or home for long: no pulse is expected
  const bool expected = header != nullptr && process.pid >= 0 &&
                        header->generation.load() == process.generation &&
                        header->state.load() == static_cast<uint32_t>(SegmentState::kRun);
  const int64_t silent_ns =
      expected ? process.silence.look(header->heartbeat.load(), header->heartbeat_ns.load(), t_ns,
                                      held_up_ns)
               : 0;
  const Pulse pulse = judge_pulse(silent_ns, process.period_ns);
  // one line when it gets worse, not one each look
  if (pulse > process.pulse) {
    const bool hung = pulse == Pulse::kHung;
    log_.write(hung ? LogLevel::kError : LogLevel::kWarning, process.name,
               std::string(hung ? "hangs: " : "late: ") + "no cycle for " +
                   std::to_string(silent_ns / kMs) + " ms" + (hung ? "; killed" : ""));
    if (hung) kill(process.pid, SIGKILL);
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

bool Supervisor::wait_for_exit(Process& process, int64_t deadline_ns) {
  if (process.pid < 0) return true;
  pollfd waiting{process.pidfd.get(), POLLIN, 0};
  const int64_t left_ns = std::max<int64_t>(deadline_ns - now_ns(), 0);
  if (poll(&waiting, 1, static_cast<int>((left_ns + kMs - 1) / kMs)) <= 0) return false;
  waitpid(process.pid, nullptr, 0);
  process.pid = -1;
  process.pidfd = {};
  write_output(process, true);
  return true;
}

void Supervisor::stop_children() {
  const int64_t begin_ns = now_ns();
  // the servo first: it writes the zero wrench while contact and sim still answer
  Process& servo = processes_.back();
  if (servo.pid >= 0) kill(servo.pid, SIGTERM);
  wait_for_exit(servo, begin_ns + kServoStopNs);
  for (Process& process : processes_) {
    if (process.pid >= 0) kill(process.pid, SIGTERM);
  }
  for (Process& process : processes_) {
    if (wait_for_exit(process, begin_ns + kStopNs)) continue;
    log_.write(LogLevel::kWarning, process.name,
               std::string(process.program) + " did not stop in time and is killed");
    kill(process.pid, SIGKILL);
    waitpid(process.pid, nullptr, 0);
    process.pid = -1;
  }
}

}  // namespace haptic
