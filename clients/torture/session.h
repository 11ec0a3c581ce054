// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "clients/hapt/session_process.h"
#include "clients/torture/force_judge.h"
#include "clients/torture/process_waits.h"
#include "clients/torture/stall_witness.h"
#include "device-io/emulator/log_reader.h"
#include "proto/ipc/handout.h"

namespace haptic {

struct TortureOptions {
  std::string folder;     // empty or new; everything is put in there
  std::string recording;  // name of the recordings without .mcap; empty: not recorded
  bool realtime = true;   // ask for real-time priorities
};

/// A frame of the servo as this program saw it. Its own time is that of the tick it was due at: a
/// servo that is held up publishes it any time later.
struct SeenFrame {
  int64_t t_ns = 0;     // of the frame
  int64_t seen_ns = 0;  // when it was found in the ring
};

/// One recorder's file; a recorder that was killed or whose session ended is followed by another.
struct RecordingPart {
  static constexpr size_t kRuns = std::numeric_limits<size_t>::max();

  std::string path;
  size_t n_seen = kRuns;  // frames seen before it was killed, told to end, or lost its session
  int64_t killed_ns = 0;  // 0: it was not, and every one of those must be in it
  std::vector<Stall> stalls = {};  // in which one that was killed had no time to write
};

/// The newest writer of a ring, as this program saw it.
struct WriterSeen {
  pid_t pid = -1;
  uint64_t generation = 0;
  int64_t first_ns = 0;  // time of the first item: of the frame, or of the question it answers
  int64_t fault_ns = 0;  // of the servo: of the newest frame that says it has latched a fault
};

/// A session to be tortured: haptic-emulator, whose hand presses into a block; hapticd with
/// haptic-faulty-contact in the place of haptic-contact; `hapt record`; and this program as one
/// more client. For as long as it lives $HAPTICD_RUNTIME_DIR and $HAPTICD_LIBEXEC point into its
/// folder.
class TortureSession {
 public:
  /// What its force is judged by.
  static ForceRules rules() { return {}; }

  /// Starts everything. Throws std::runtime_error with one line.
  explicit TortureSession(const TortureOptions& options);
  ~TortureSession();
  TortureSession(const TortureSession&) = delete;

  /// Reads what the rings and the emulator's log have to say. To be called at least once a second:
  /// a ring holds four. Throws std::runtime_error when the emulator has ended.
  void update();
  /// Updates for so long.
  void pause(int64_t duration_ns);
  /// Updates until the condition holds; false: it did not in time.
  bool wait_until(const std::function<bool()>& condition, int64_t patience_ns);
  /// Until the hand feels the spring in commands after from_ns; the time of the first.
  std::optional<int64_t> wait_whole(int64_t from_ns, int64_t patience_ns);

  /// What the emulator has written since forget_before().
  const std::vector<EmulatorRecord>& records() const { return records_; }
  void forget_before(int64_t t_ns);
  std::span<const EmulatorRecord> records_since(int64_t t_ns) const;
  /// Where the machine stood still, by both witnesses: a thread of ours and the emulator.
  std::vector<Stall> stalls(int64_t since_ns, bool emulator_too) const;
  /// The same for processes that start: that is done at normal priority.
  std::vector<Stall> stalls_of_starts(int64_t since_ns) const {
    return merge_stalls(witness_.stalls(since_ns), normal_witness_.stalls(since_ns));
  }

  const WriterSeen& contact() const { return watch_->contact_seen; }
  const WriterSeen& sim() const { return watch_->sim_seen; }
  const WriterSeen& servo() const { return watch_->servo_seen; }
  SessionProcess& hapticd() { return *hapticd_; }
  SessionProcess& emulator() { return *emulator_; }
  SessionProcess* recorder() { return recorder_.get(); }  // null: nothing is recorded
  const std::string& name() const { return name_; }
  const std::string& folder() const { return options_.folder; }

  /// Says a line to hapticd; its answer, or "error: …" where there is none.
  std::string ask(const std::string& line) const;
  /// Returns when, and waits for its end.
  int64_t kill_hapticd();
  /// A new hapticd in the place of one that was killed, and a new recorder with it.
  void restart_hapticd();
  void kill_recorder();
  void start_recorder();
  /// Ends recorder, hapticd and emulator in this order.
  void stop();

  // for the account of samples
  const std::vector<RecordingPart>& parts() const { return parts_; }
  const std::vector<SeenFrame>& published() const { return published_; }  // by the servo
  uint64_t unseen() const { return unseen_ + watch_->lost(); }  // frames that we missed ourselves

 private:
  /// Attached to the rings.
  struct Watch {
    Attachments attachments;
    RingSource<&ServoChannels::frames> servo;
    RingSource<&ContactChannels::sets> contact;
    RingSource<&SimChannels::frames> sim;
    WriterSeen servo_seen, contact_seen, sim_seen;
    explicit Watch(FileDescriptor socket);
    void drain(std::vector<SeenFrame>& published);
    uint64_t lost() const { return servo.lost(); }
  };
  /// A variable of the environment, until this is gone.
  class Variable {
   public:
    Variable(const char* name, const std::string& value);
    ~Variable();
    Variable(const Variable&) = delete;

   private:
    const char* name_;
    std::optional<std::string> before_;
  };

  void link_programs(const std::string& from) const;
  std::string write_config() const;
  void start_emulator();
  void start_hapticd();
  void end_part();

  TortureOptions options_;
  std::string name_ = "torture";
  std::string programs_;
  Variable runtime_dir_, libexec_;
  StallWitness witness_, normal_witness_;
  std::unique_ptr<SessionProcess> emulator_, hapticd_, recorder_;
  std::optional<ProcessWaits> recorder_waits_;
  std::unique_ptr<Watch> watch_;
  EmulatorLogReader reader_;
  std::vector<EmulatorRecord> records_;
  std::vector<RecordingPart> parts_;
  std::vector<SeenFrame> published_;
  uint64_t unseen_ = 0;
};

/// Path of a program on $PATH; empty where there is none.
std::string find_on_path(const std::string& program);

}  // namespace haptic
