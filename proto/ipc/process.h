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
#include "proto/ipc/attachments.h"
#include "proto/ipc/handout_message.h"
#include "proto/ipc/segment.h"
#include "proto/math/assert.h"
#include "proto/os/message.h"
#include "proto/os/realtime.h"

/// Common frame of hapticd's three children: arguments, configuration, signals, its own segment and
/// the attached ones. A whole process reads:
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

/// Exit codes of the children, as hapticd interprets them.
inline constexpr int kExitClean = 0;
inline constexpr int kExitCrash = 1;     // restart
inline constexpr int kExitBadInput = 2;  // config or mesh: a restart would not help
inline constexpr int kExitNoDevice =
    3;  // the device is silent: bad input, unless it was there once

/// Begins a line on a child's stderr that names what the child prepares before its loop runs. If it
/// dies meanwhile, hapticd names that as the cause.
inline constexpr std::string_view kPreparing = "preparing ";
/// Begin lines of a child that hapticd logs as a warning or an error; every other is information.
inline constexpr std::string_view kWarningLine = "warning: ";
inline constexpr std::string_view kErrorLine = "error: ";

/// The device does not answer or is a different one. The text says how to mend it.
struct DeviceError : MessageError {
  using MessageError::MessageError;
};

/// hapticd's command line for a child: --config-fd N --control-fd M --generation G, plus
/// --device-fd D for the servo of a device with a node, or --spare-fd S for a spare.
struct ChildArguments {
  int config_fd = -1;   // sealed memfd with a SessionConfig
  int control_fd = -1;  // this end of the socket pair
  uint64_t generation = 0;
  int device_fd = -1;  // the open device node; −1: the servo opens it itself
  int spare_fd = -1;   // tells a spare to take over; −1: not a spare
};

/// Throws std::invalid_argument with the usage line.
ChildArguments parse_child_arguments(int argc, char** argv);

/// Parses the arguments, runs, and turns exceptions into an exit code and one line on stderr:
/// std::system_error, SegmentError, HandoutError and bad_alloc are crashes (a restart may help),
/// DeviceError is a missing device, all others are bad input.
int run_child(int argc, char** argv, int (*run)(const ChildArguments&));

/// From now on SIGTERM, SIGINT and SIGHUP only set the flag of stop_requested(); SIGPIPE is
/// ignored.
void catch_stop_signals();
bool stop_requested() noexcept;
/// Sets the flag.
void request_stop() noexcept;

/// SIGTERM when the parent dies; at once if it is dead already, shown by the hung-up socket pair
/// (its pid may have been reused).
void die_with_parent(int control_fd);

/// The byte that a spare sends over its socket once it waits, and the one that ends its wait.
inline constexpr char kSpareReady = 'r', kSpareTurn = 't';

/// A spare sleeps until its predecessor is dead and calls `look` once a second; any other process
/// continues at once. False: asked to stop, or hapticd is gone.
bool await_turn(int spare_fd, const std::function<void()>& look);

/// A copy of the configuration in a sealed memfd. Throws SegmentError if its size is not that of
/// this build's SessionConfig.
SessionConfig read_config(int config_fd);

/// Options of a child's attach thread: locks each segment if the session is real time, prints
/// refused segments, and requests a stop when hapticd is gone.
AttachOptions child_attach_options(const SessionConfig& config);

/// One child of hapticd. The constructor copies the configuration and makes the segment. Until
/// start() returns anything may throw, and SIGTERM ends the process at once, so that a long
/// preparation does not delay a stop; afterwards nothing throws, and SIGTERM ends the loop.
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

  /// A ring of another process, of the hand or the client with that number; make it before start().
  template <auto kMember>
  RingSource<kMember> ring(Start start, uint32_t number = kFirstHand) {
    return attachments_.ring<kMember>(start, number);
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

  /// Makes this thread as real time as the session wants and the kernel permits (reported in the
  /// header and the kStarted event). Without `realtime` in the config nothing is requested.
  void enter_realtime(RealtimeOptions wanted) {
    if (config_.realtime == 0) wanted = {.fifo_priority = 0, .lock_memory = false};
    realtime_ = haptic::enter_realtime(wanted);
    segment_.set_realtime(realtime_);
  }

  /// Offers the segment and marks its writer as running.
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

  /// Offers a sealed file beside the segment. Throws HandoutError.
  void offer_file(SegmentId id, const char* name, int fd) const {
    offer_segment(arguments_.control_fd, id, arguments_.generation, name, fd);
  }

  /// True if SIGTERM, SIGINT or the end of hapticd asks the loop to end.
  bool stopping() const noexcept { return stop_requested(); }

  /// Once per cycle: heartbeat for the watchdog.
  void beat(const Tick& tick) noexcept {
    HAPTIC_ASSERT(tick.index >= last_tick_.index);
    last_tick_ = tick;
    segment_.beat(tick.index, tick.deadline_ns + tick.late_ns);
  }

  void event(EventCode code, const std::array<double, 5>& numbers) noexcept {
    segment_.channels().events.publish(
        {now_ns(), static_cast<uint32_t>(code), static_cast<uint32_t>(Channels::kId), numbers});
  }

  /// After the loop: publishes a summary and marks the segment as ended.
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
