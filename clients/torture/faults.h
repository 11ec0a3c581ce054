// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "clients/torture/session.h"
#include "device-io/emulator/fault_order.h"

namespace haptic {

/// What can be done to a running session.
enum class FaultKind {
  kContactKill,
  kContactHang,
  kContactStop,
  kContactNaN,
  kContactInfinity,
  kContactTenTimes,
  kContactThousandTimes,
  kContactLies,
  kSimKill,
  kSimStop,
  kServoKill,
  kServoStop,
  kServoPause,
  kHapticdKill,
  kHapticdServoKill,
  kHapticdStop,
  kRecorderKill,
  kRecorderStop,
  kClientKill,
  kClientStop,
  kManyClients,
  kPoseJump,
  kDeviceSilent,
  kDeviceFrozen,
  kDeviceOldFirst,
  kDeviceDelayed,
  kDeviceNoise,
  kMemory,
  kBusy,
};
inline constexpr size_t kFaultKinds = 29;

/// What is known of a kind beforehand.
struct FaultInfo {
  FaultKind kind;
  std::string_view name;
  int share;                               // of a hundred faults
  Effect effect;                           // on the force
  int64_t goal_ns;                         // whole again after that; 0: nothing is stated
  int64_t zero_ns = ForceRules{}.zero_ns;  // where the force is to be zero: after that
  bool is_misled = false;                  // the device says what is not so
};
extern const std::array<FaultInfo, kFaultKinds> kFaults;

const FaultInfo& info_of(FaultKind kind);

/// How a fault went.
struct FaultOutcome {
  FaultKind kind{};
  std::vector<std::string> violations;   // one line each: what, when, how much
  std::vector<std::string> before;       // since the fault before: what breaks there is neither's
  std::optional<int64_t> zero_after_ns;  // from the fault to the first zero; nothing: never zero
  std::optional<int64_t> recovery_ns;    // from the restart (or the end of the cause) to the spring
  int64_t begin_ns = 0;
  size_t excused = 0;    // commands that were not judged, because the machine had stood still
  std::string left_out;  // why it was not done; empty: it was
};

/// Does faults to a session, waits each time until it is whole again, and has the force judged by
/// what the emulated device received. Same seed, same lengths of stops.
class FaultInjector {
 public:
  FaultInjector(TortureSession& session, uint64_t seed) : session_(session), random_(seed) {}

  FaultOutcome inject(FaultKind kind);

  /// When a kind may be done next: hapticd waits longer before each restart of a process that lived
  /// less than ten seconds, so that a second death sooner is not one that 200 ms are stated for.
  int64_t ready_ns(FaultKind kind) const;

 private:
  /// What the judge has to know of a fault that was done. It begins when it is known to be done: we
  /// may be held up ourselves before.
  struct Done {
    int64_t begin_ns = 0;
    int64_t from_ns = 0;  // before it was done
    int64_t over_ns = 0;
    int64_t soft_ns = 0;           // first tick of a new servo
    int64_t whole_from_ns = 0;     // commands from here on count for wholeness
    int64_t recovery_from_ns = 0;  // and this is where the time begins
    bool recovers = true;          // false: the force never left, there is nothing to time
    int64_t recovered_ns = 0;      // where it is not the force that tells; 0: it is
    int64_t waited_ns = 0;         // for a processor, by who was started in another's place
    std::vector<std::string> problems = {};
    std::string left_out = {};
  };

  Done inflict(FaultKind kind);
  Done kill_contact(bool hang);
  Done stop_contact();
  Done close_by(const std::function<void()>& cause, const std::function<void()>& cure = {});
  Done lie(EmulatorFault how);
  Done slow_contact(FaultKind kind);
  Done lie_in_contact();
  Done kill_sim();
  Done stop_sim();
  Done fell_servo(int signal);
  Done pause_servo();
  Done kill_hapticd(bool servo_too);
  Done stop_hapticd();
  Done kill_recorder();
  Done stop_recorder();
  Done fell_client(int signal);
  Done fell_many_clients();
  Done silence_device();
  Done stress(const std::vector<std::string>& words);
  Done stop_for(const std::function<void(int)>& send, int64_t least_ns, int64_t most_ns);
  void clear_fault(Done& done);
  void wait_for_spare(Done& done);
  int64_t between(int64_t least_ns, int64_t most_ns);
  std::vector<std::string> judge_calm(int64_t until_ns) const;
  void judge(const FaultInfo& info, const Done& done, FaultOutcome& outcome);

  TortureSession& session_;
  std::mt19937_64 random_;
  int64_t contact_restarted_ns_ = 0, sim_restarted_ns_ = 0;  // since hapticd started
  int64_t judged_ns_ = 0;                                    // so far
};

}  // namespace haptic
