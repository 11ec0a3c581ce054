// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <array>
#include <cstdint>
#include <ctime>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "proto/config/config.h"
#include "proto/ipc/attachments.h"
#include "proto/ipc/control_socket.h"
#include "proto/ipc/handout_server.h"
#include "proto/ipc/segment.h"
#include "servo/hapticd/child_process.h"
#include "servo/hapticd/device_guard.h"
#include "servo/hapticd/log.h"
#include "servo/hapticd/restart_policy.h"
#include "servo/hapticd/spare.h"
#include "servo/hapticd/status.h"

namespace haptic {

/// Starts haptic-sim, haptic-contact and haptic-servo, distributes their segments, restarts what
/// dies and stops everything in the order that ends with a zero wrench. Its main thread is real
/// time, so neither a restart nor the signal of its own end to its children waits for a processor.
class Supervisor {
 public:
  /// Takes the session's name. `config_text` is the session file as read, for those who may control
  /// the session. Throws HandoutError, SegmentError, or std::runtime_error if a program is missing.
  Supervisor(const SessionConfig& config, std::string config_text, const std::string& session,
             HapticdLog& log);
  ~Supervisor();
  Supervisor(const Supervisor&) = delete;

  /// Runs until a stop signal or a permanent failure; returns hapticd's exit code.
  int run();

 private:
  struct Process {
    const char* program;
    SegmentId id;
    const char* name;
    int64_t period_ns;
    ChildProcess child = {};
    uint64_t generation = 0;
    uint64_t last_generation = 0;     // newest, its own or its spare's
    uint64_t offered_generation = 0;  // of the segment offered last
    bool was_ready = false;           // it was a ready spare: nothing is left to prepare
    int deaths_in_a_row = 0;
    int deaths_unborn = 0;  // in a row, before its loop ran
    bool ever_ran = false;
    int64_t started_ns = 0;
    int64_t restart_at_ns = 0;  // while it is not running
    Silence silence = {};
    Pulse pulse = Pulse::kFine;
  };
  /// A requested change that the servo has not yet echoed.
  struct Unanswered {
    uint64_t peer;
    uint64_t revision;
    bool clears_fault;
    int64_t give_up_ns;
    std::string warning;
  };

  /// Whether it holds the device's node, as hapticd does.
  bool drives(const Process& process) const {
    return guard_.has_value() && process.id == ServoChannels::kId;
  }
  /// Whether its device is gone: it is not started until the device is back.
  bool lacks_device(const Process& process) const { return drives(process) && guard_->node() < 0; }
  int64_t start_time(const Process& process) const;
  void keep_fault();
  void start(Process& process);
  void launch(const Process& process, uint64_t generation, ChildProcess& child, int spare_fd = -1);
  void promote_spare(Process& contact);
  void reap_spare();
  void watch_spare(int64_t t_ns);
  int64_t silence_of(Process& process, int64_t t_ns, int64_t held_up_ns);
  void reap(Process& process);
  void restart_due(int64_t t_ns);
  void wait_for_work(int64_t until_ns);
  void rest() const;
  void write_output(const char* name, ChildProcess& child, bool ended);
  bool is_hopeless(Process& process, int status);
  const SegmentHeader* header_of(const Process& process) noexcept;
  void tell_waiting(int64_t t_ns);
  void take_offer(const Announcement& offer);
  void take_command(uint64_t peer, std::string_view line);
  void answer_commands(int64_t t_ns);
  SessionStatus status();
  std::string answer_watcher(std::string_view line);
  void lead(uint64_t peer, std::string_view line, bool was_leading);
  void watch_lead(int64_t t_ns);
  void publish_control(int64_t t_ns);
  void watch_device(int64_t t_ns);
  void watch_place();
  void watch_pulse(Process& process, int64_t t_ns, int64_t held_up_ns);
  void write_events();
  template <typename Events>
  void write_events_of(const char* name, Events& events, uint64_t& lost);
  void stop_children();
  void stop_child(const char* name, const char* program, ChildProcess& child, int64_t deadline_ns);

  const SessionConfig config_;
  const std::string config_text_, session_;
  const std::time_t since_ = std::time(nullptr);
  HapticdLog& log_;
  std::string folder_;  // of the programs
  HandoutServer server_;
  ControlServer commands_;
  FileDescriptor config_file_;
  FileDescriptor signals_;
  SegmentWriter<ControlChannels> control_{1};
  ControlFrame control_frame_{};
  std::array<Process, 3> processes_;  // sim, contact, servo, in the order of starting
  Process& contact_ = processes_[1];
  Spare spare_;
  // hapticd reads its children's events like any client
  Attachments attachments_;
  RingSource<&SimChannels::events> sim_events_;
  RingSource<&ContactChannels::events> contact_events_;
  RingSource<&ServoChannels::events> servo_events_;
  RingSource<&ServoChannels::frames> servo_frames_;
  RingSource<&SimChannels::frames> sim_frames_;
  ServoFrame servo_frame_{};  // the newest
  SceneFrame scene_frame_{};  // the newest
  std::optional<DeviceGuard> guard_;
  uint64_t told_releases_ = 0;
  std::array<uint64_t, 3> lost_events_{};
  std::vector<Unanswered> unanswered_;
  int64_t told_waiting_ns_ = 0;
  int64_t woke_ns_ = 0;
  int exit_code_ = 0;
  bool stopping_ = false;
};

}  // namespace haptic
