// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "proto/config/config.h"
#include "proto/ipc/handout.h"
#include "proto/ipc/segment.h"
#include "proto/os/message.h"
#include "proto/os/realtime.h"

/// The shell that the three children of hapticd share: arguments, configuration, signals, the own
/// segment and the attached ones. A whole process reads:
///
///   int run(const ChildArguments& arguments) {
///     Child<ContactChannels> child(arguments);      // maps the config, makes the segment
///     auto hand = child.ring<&ServoChannels::frames>(Start::kNewest);
///     auto scene = child.ring<&SimChannels::frames>(Start::kNewest);
///     const ContactModel model = build(child.config());  // may throw: exit code 2, no restart
///     child.start({.fifo_priority = 60, .lock_memory = true});  // offer, attach, go real time
///     DeadlineClock clock(period_ns(child.config().contact_poll_rate));
///     ServoFrame frame;
///     while (!child.stopping()) {
///       const Tick tick = clock.wait();
///       child.beat(tick);
///       if (hand.latest(frame)) child.channels().sets.publish(step(model, state, frame));
///     }
///     child.finish();
///     return kExitClean;
///   }
///   int main(int argc, char** argv) { return haptic::run_child(argc, argv, run); }
namespace haptic {

/// SCHED_FIFO of whoever replaces what died: hapticd's main thread and the threads that map a new
/// writer's segment. Below every loop of a session (contact 60, servo 80), and above whatever else
/// runs: a thread of normal priority waits tens of milliseconds for a processor on a busy machine,
/// and cannot even die before.
inline constexpr int kHousekeepingPriority = 40;

/// Exit codes of the children, as hapticd understands them.
inline constexpr int kExitClean = 0;
inline constexpr int kExitCrash = 1;     // restart it
inline constexpr int kExitBadInput = 2;  // config or mesh: a restart would not help
inline constexpr int kExitNoDevice =
    3;  // the device is silent: bad input, unless it was there once

/// Begins a line on a child's stderr that names what it now prepares, before its loop runs. Should
/// it die of that, hapticd can say of what.
inline constexpr std::string_view kPreparing = "preparing ";

/// The device does not answer, or is another one. The text says how to mend it.
struct DeviceError : MessageError {
  using MessageError::MessageError;
};

/// What hapticd passes on the command line: --config-fd N --control-fd M --generation G, to the
/// servo of a device with a node --device-fd D, and to a spare --spare-fd S.
struct ChildArguments {
  int config_fd = -1;   // sealed memfd with a SessionConfig
  int control_fd = -1;  // this end of the socket pair
  uint64_t generation = 0;
  int device_fd = -1;  // the open device node; −1: the servo opens it itself
  int spare_fd = -1;   // over which a spare is told that its turn has come; −1: it is no spare
};

/// Throws std::invalid_argument with the usage line.
ChildArguments parse_child_arguments(int argc, char** argv);

/// Parses the arguments, runs, and turns what is thrown into an exit code and one line on stderr:
/// std::system_error, SegmentError, HandoutError and bad_alloc are crashes (restart may help),
/// DeviceError is a missing device, all other exceptions are bad input.
int run_child(int argc, char** argv, int (*run)(const ChildArguments&));

/// SIGTERM, SIGINT and SIGHUP from now on only raise a flag that stop_requested() reads; SIGPIPE is
/// ignored.
void catch_stop_signals();
bool stop_requested() noexcept;
/// Raises the flag by hand.
void request_stop() noexcept;

/// SIGTERM when the parent dies, and at once when it is dead already, which the hung-up socket pair
/// shows (a pid could not: it may be reused).
void die_with_parent(int control_fd);

/// The word that a spare says over its socket once it waits, and the one that ends its wait.
inline constexpr char kSpareReady = 'r', kSpareTurn = 't';

/// A spare's wait until its predecessor is dead; who is no spare goes on at once. It sleeps, and
/// calls `look` once a second. False: it is asked to stop, or hapticd is gone.
bool await_turn(int spare_fd, const std::function<void()>& look);

/// A copy of the configuration in a sealed memfd. Throws SegmentError where the size is not that of
/// a SessionConfig of this build.
SessionConfig read_config(int config_fd);

/// What a child's attach thread does: locks each segment where the session is real time, prints a
/// refused segment, and asks for a stop when hapticd is gone.
AttachOptions child_attach_options(const SessionConfig& config);

/// One child of hapticd. The constructor copies the configuration and makes the segment. Until
/// start() returns everything may throw, and SIGTERM ends the process on the spot, so that a long
/// preparation does not hold up a stop; afterwards nothing throws, and SIGTERM ends the loop.
template <typename Channels>
class Child {
 public:
  explicit Child(const ChildArguments& arguments)
      : arguments_(arguments),
        config_(prepare(arguments)),
        segment_(arguments.generation),
        attachments_(FileDescriptor(arguments.control_fd), child_attach_options(config_)) {}

  const SessionConfig& config() const noexcept { return config_; }
  Channels& channels() noexcept { return segment_.channels(); }
  SegmentWriter<Channels>& segment() noexcept { return segment_; }
  uint64_t generation() const noexcept { return arguments_.generation; }

  /// A ring of another process; to be made before start().
  template <auto kMember>
  RingSource<kMember> ring(Start start) {
    return attachments_.ring<kMember>(start);
  }

  /// attach(), enter_realtime() and offer() in one.
  void start(const RealtimeOptions& wanted) {
    attach();
    enter_realtime(wanted);
    offer();
  }

  /// Starts to attach the others' segments and catches the stop signals.
  void attach() {
    attachments_.start();
    catch_stop_signals();
  }

  /// Makes this thread as real time as the session wants and the kernel grants (both in the header
  /// and in the kStarted event). Without `realtime` in the config nothing is asked for.
  void enter_realtime(RealtimeOptions wanted) {
    if (config_.realtime == 0) wanted = {.fifo_priority = 0, .lock_memory = false};
    realtime_ = haptic::enter_realtime(wanted);
    segment_.set_realtime(realtime_);
  }

  /// Offers the segment and says that its writer runs: from now on it is heard.
  void offer() {
    segment_.beat(0, now_ns());
    segment_.set_state(SegmentState::kRun);
    event(EventCode::kStarted,
          {static_cast<double>(segment_.header().pid.load()),
           static_cast<double>(arguments_.generation), static_cast<double>(realtime_.bits),
           static_cast<double>(realtime_.fifo_errno), static_cast<double>(realtime_.memory_errno)});
    offer_segment(arguments_.control_fd, Channels::kId, arguments_.generation, Channels::kName,
                  segment_.fd());
  }

  /// Whether SIGTERM, SIGINT or the end of hapticd asks the loop to end.
  bool stopping() const noexcept { return stop_requested(); }

  /// Once a cycle: tells the watchdog that the loop moves.
  void beat(const Tick& tick) noexcept {
    last_tick_ = tick;
    segment_.beat(tick.index, tick.deadline_ns + tick.late_ns);
  }

  void event(EventCode code, const std::array<double, 5>& numbers) noexcept {
    segment_.channels().events.publish(
        {now_ns(), static_cast<uint32_t>(code), static_cast<uint32_t>(Channels::kId), numbers});
  }

  /// After the loop: says how it went and that nothing more will come.
  void finish() noexcept {
    event(EventCode::kStopped, {static_cast<double>(last_tick_.index + 1 - last_tick_.skipped),
                                static_cast<double>(last_tick_.skipped), 0, 0, 0});
    segment_.set_state(SegmentState::kDead);
  }

 private:
  static SessionConfig prepare(const ChildArguments& arguments) {
    die_with_parent(arguments.control_fd);
    return read_config(arguments.config_fd);
  }

  ChildArguments arguments_;
  SessionConfig config_;
  SegmentWriter<Channels> segment_;
  Attachments attachments_;
  RealtimeReport realtime_;
  Tick last_tick_{};
};

}  // namespace haptic
