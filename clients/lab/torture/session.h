// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "clients/hapt/session_process.h"
#include "clients/lab/torture/force_judge.h"
#include "clients/lab/torture/process_waits.h"
#include "clients/lab/torture/session_text.h"
#include "clients/lab/torture/stall_witness.h"
#include "device-io/emulator/log_reader.h"
#include "proto/ipc/attachments.h"

namespace haptic {

struct TortureOptions {
  std::string folder;     // empty or new; holds all files
  std::string recording;  // name of the recordings without .mcap; empty: none
  bool realtime = true;   // ask for real-time priorities
  bool six = false;       // a device with six motors, whose hand also feels torque
  bool bodies = false;    // the block has mass and lies on the ground; at times the hand holds it
  bool given = false;     // a client moves the block, which stands
};

/// A frame of the servo as seen by this program. Its time stamp is that of its tick; a stalled
/// servo may publish it any time later.
struct SeenFrame {
  int64_t t_ns = 0;     // time stamp of the frame
  int64_t seen_ns = 0;  // when it was found in the ring
};

/// The file of one recorder; a recorder that was killed or lost its session has a successor.
struct RecordingPart {
  static constexpr size_t kRuns = std::numeric_limits<size_t>::max();

  std::string path;
  size_t n_seen = kRuns;  // frames seen before it was killed, told to end, or lost its session
  int64_t killed_ns = 0;  // 0: not killed, and every one of those frames must be in the file
  std::vector<Stall> stalls = {};  // a killed recorder could not write in these
};

/// The newest writer of a ring, as seen by this program.
struct WriterSeen {
  pid_t pid = -1;
  uint64_t generation = 0;
  int64_t first_ns = 0;  // time of its first frame, or of the question its first set answers
  int64_t fault_ns = 0;  // servo: time of the newest frame with a latched fault
};

/// A session for fault injection: haptic-emulator, whose hand presses into a block; hapticd with
/// haptic-faulty-contact in place of haptic-contact; `hapt record`; and this program as another
/// client. During its lifetime $HAPTICD_RUNTIME_DIR and $HAPTICD_LIBEXEC point into its folder.
class TortureSession {
 public:
  /// The rules for its forces, and for its torques where it has any.
  std::vector<ForceRules> rules() const;
  bool has_bodies() const { return options_.bodies; }
  bool holds() const { return holds_; }

  /// The hand takes the block, lifts it and rests; false if it does not hang there after
  /// patience_ns. Also where it held it before.
  bool take(int64_t patience_ns);
  /// The hand lets go of the block and presses it again.
  bool let_go(int64_t patience_ns);

  /// Starts all processes. Throws std::runtime_error with one line.
  explicit TortureSession(const TortureOptions& options);
  ~TortureSession();
  TortureSession(const TortureSession&) = delete;

  /// Reads the rings and the emulator's log. Call it at least once a second: a ring holds four.
  /// Throws std::runtime_error if the emulator has ended.
  void update();
  /// Updates for that long.
  void pause(int64_t duration_ns);
  /// Updates until the condition holds; false after patience_ns.
  bool wait_until(const std::function<bool()>& condition, int64_t patience_ns);
  /// Waits for recovery after from_ns; returns the time of the first such command.
  std::optional<int64_t> wait_whole(int64_t from_ns, int64_t patience_ns);

  /// Waits until a block that is held hangs so still that the next fault finds it at rest; false
  /// after patience_ns.
  bool wait_calm(int64_t patience_ns);

  /// Records of the emulator since forget_before().
  const std::vector<EmulatorRecord>& records() const { return records_; }
  void forget_before(int64_t t_ns);
  std::span<const EmulatorRecord> records_since(int64_t t_ns) const;
  /// Stalls of the machine, by the witness threads and optionally the emulator.
  std::vector<Stall> stalls(int64_t since_ns, bool emulator_too) const;
  /// Stalls that a starting process may have met: it runs at normal priority.
  std::vector<Stall> stalls_of_starts(int64_t since_ns) const {
    return merge_stalls(witness_.stalls(since_ns), normal_witness_.stalls(since_ns));
  }

  const WriterSeen& contact() const { return watch_->contact_seen; }
  const WriterSeen& sim() const { return watch_->sim_seen; }
  const WriterSeen& servo() const { return watch_->servo_seen; }
  /// The newest scene; null: none has been seen.
  const SceneFrame* scene() const { return watch_->scene ? &*watch_->scene : nullptr; }
  /// Starts the next client that gives; false where it or the honest one does not come to give.
  bool start_giver(int64_t patience_ns);
  /// The client that was started last, its number and its object in the newest scene.
  SessionProcess& giver() { return *giver_; }
  uint32_t giver_number() const { return giver_number_; }
  const SceneObject* given_object(uint32_t client) const;
  /// The client that moves the block; only where it is given. Started anew, it takes the place of
  /// one that is gone.
  SessionProcess& holder() { return *holder_; }
  void start_holder();

  SessionProcess& hapticd() { return *hapticd_; }
  SessionProcess& emulator() { return *emulator_; }
  SessionProcess* recorder() { return recorder_.get(); }  // null: not recording
  const std::string& name() const { return name_; }
  const std::string& folder() const { return options_.folder; }

  /// Sends a line to hapticd; returns its answer, or "error: …" if there is none.
  std::string ask(const std::string& line) const;
  /// Kills hapticd, waits for its end and returns when it was killed.
  int64_t kill_hapticd();
  /// Starts a new hapticd after a kill, and a new recorder.
  void restart_hapticd();
  void kill_recorder();
  void start_recorder();
  /// Ends recorder, hapticd and emulator in this order.
  void stop();

  // for the account of samples
  const std::vector<RecordingPart>& parts() const { return parts_; }
  const std::vector<SeenFrame>& published() const { return published_; }  // by the servo
  uint64_t unseen() const { return unseen_ + watch_->lost(); }  // frames missed by this program

 private:
  /// This program's attachments to the rings.
  struct Watch {
    Attachments attachments;
    RingSource<&ServoChannels::frames> servo;
    RingSource<&ContactChannels::sets> contact;
    RingSource<&SimChannels::frames> sim;
    WriterSeen servo_seen, contact_seen, sim_seen;
    std::optional<SceneFrame> scene;
    explicit Watch(FileDescriptor socket);
    void drain(std::vector<SeenFrame>& published);
    uint64_t lost() const { return servo.lost(); }
  };
  /// Sets an environment variable and restores it on destruction.
  class Variable {
   public:
    Variable(const char* name, const std::string& value);
    ~Variable();
    Variable(const Variable&) = delete;

   private:
    const char* name_;
    std::optional<std::string> before_;
  };

  std::optional<int64_t> wait_whole(std::vector<ForceRules> parts, int64_t from_ns,
                                    int64_t patience_ns);
  void link_programs(const std::string& from) const;
  std::string write_config() const;
  void start_emulator();
  void start_hapticd();
  std::unique_ptr<SessionProcess> run_giver(uint32_t client) const;
  bool is_let_in(size_t object, uint32_t client) const;
  void end_part();

  TortureOptions options_;
  std::string name_ = "torture";
  bool holds_ = false;
  std::string programs_;
  Variable runtime_dir_, libexec_;
  StallWitness witness_, normal_witness_;
  std::unique_ptr<SessionProcess> emulator_, hapticd_, recorder_, giver_, bystander_, holder_;
  uint32_t giver_number_ = 0;
  std::optional<ProcessWaits> recorder_waits_;
  std::unique_ptr<Watch> watch_;
  EmulatorLogReader reader_;
  std::vector<EmulatorRecord> records_;
  std::vector<RecordingPart> parts_;
  std::vector<SeenFrame> published_;
  uint64_t unseen_ = 0;
};

/// Path of a program on $PATH; empty if there is none.
std::string find_on_path(const std::string& program);

}  // namespace haptic
