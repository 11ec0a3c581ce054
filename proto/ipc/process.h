// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

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
///     auto hand = child.ring<&ServoChannels::frames>(Start::kNewest);  // of its own hand
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

/// hapticd's command line for a child: --config-fd N --control-fd M --generation G --hand H, plus
/// --device-fd D for the servo of a device with a node, or --spare-fd S for a spare.
struct ChildArguments {
  int config_fd = -1;   // sealed memfd with a SessionConfig for each hand
  int control_fd = -1;  // this end of the socket pair
  uint64_t generation = 0;
  int device_fd = -1;          // the open device node; −1: the servo opens it itself
  int spare_fd = -1;           // tells a spare to take over; −1: not a spare
  uint32_t hand = kFirstHand;  // of a servo or a contact
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

/// The byte that a spare sends over its socket once it waits, and the one that ends its wait: this
/// and the number of the hand whose contact is dead.
inline constexpr char kSpareReady = 'r', kSpareTurn = '0';

/// A spare sleeps until a contact is dead, calling `look` once a second, and returns the hand that
/// it was of. Empty: asked to stop, or hapticd is gone.
std::optional<uint32_t> await_turn(int spare_fd, const std::function<void()>& look);

/// A copy of the configurations in a sealed memfd, by hand. Throws SegmentError if its size is not
/// that of this build's.
std::vector<SessionConfig> read_configs(int config_fd);

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
        hands_(prepare(arguments)),
        attachments_(FileDescriptor(arguments.control_fd), child_attach_options(config())) {
    for (uint32_t hand = 0; hand < hands_.size(); ++hand) {
      const bool is_possible = hand == arguments.hand || arguments.spare_fd >= 0;
      segments_.push_back(is_possible ? std::make_unique<Writer>(arguments.generation, hand)
                                      : nullptr);
    }
  }

  uint32_t hand() const noexcept { return arguments_.hand; }
  uint32_t n_hands() const noexcept { return static_cast<uint32_t>(hands_.size()); }
  /// The session as its own hand has it, or another one.
  const SessionConfig& config() const noexcept { return hands_[arguments_.hand]; }
  const SessionConfig& config(uint32_t hand) const { return hands_.at(hand); }
  std::span<const SessionConfig> hands() const noexcept { return hands_; }
  Channels& channels() noexcept { return segment().channels(); }
  SegmentWriter<Channels>& segment() noexcept { return *segments_[arguments_.hand]; }
  uint64_t generation() const noexcept { return arguments_.generation; }

  /// A spare is from now on of this hand.
  void become(uint32_t hand) {
    HAPTIC_ASSERT(hand < segments_.size() && segments_[hand] != nullptr);
    arguments_.hand = hand;
  }

  /// A ring of another process: of its own hand, or of the hand or the client with that number.
  /// Make it before start().
  template <auto kMember>
  RingSource<kMember> ring(Start start) {
    return ring<kMember>(start, arguments_.hand);
  }
  template <auto kMember>
  RingSource<kMember> ring(Start start, uint32_t number) {
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
    if (config().realtime == 0) wanted = {.fifo_priority = 0, .lock_memory = false};
    realtime_ = haptic::enter_realtime(wanted);
    segment().set_realtime(realtime_);
  }

  /// Offers the segment and marks its writer as running.
  void offer() {
    segment().beat(0, now_ns());
    segment().set_state(SegmentState::kRun);
    event(EventCode::kStarted,
          {static_cast<double>(segment().header().pid.load()),
           static_cast<double>(arguments_.generation), static_cast<double>(realtime_.bits),
           static_cast<double>(realtime_.fifo_errno), static_cast<double>(realtime_.memory_errno)});
    const SegmentSpec spec = segment_spec<Channels>(hand());
    offer_segment(arguments_.control_fd, spec.id, arguments_.generation, spec.name, segment().fd());
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
    segment().beat(tick.index, tick.deadline_ns + tick.late_ns);
  }

  void event(EventCode code, const std::array<double, 5>& numbers) noexcept {
    segment().channels().events.publish({now_ns(), static_cast<uint32_t>(code),
                                         static_cast<uint32_t>(segment_spec<Channels>(hand()).id),
                                         numbers});
  }

  /// After the loop: publishes a summary and marks the segment as ended.
  void finish() noexcept {
    event(EventCode::kStopped, {static_cast<double>(last_tick_.index + 1 - last_tick_.skipped),
                                static_cast<double>(last_tick_.skipped), 0, 0, 0});
    segment().set_state(SegmentState::kDead);
  }

 private:
  using Writer = SegmentWriter<Channels>;

  static std::vector<SessionConfig> prepare(const ChildArguments& arguments) {
    die_with_parent(arguments.control_fd);
    std::vector<SessionConfig> hands = read_configs(arguments.config_fd);
    if (arguments.hand < hands.size()) return hands;
    throw std::invalid_argument("the session has no hand " + std::to_string(arguments.hand));
  }

  ChildArguments arguments_;
  std::vector<SessionConfig> hands_;
  std::vector<std::unique_ptr<Writer>> segments_;  // by hand; null: it cannot become of that one
  Attachments attachments_;
  RealtimeReport realtime_;
  Tick last_tick_{};
};

}  // namespace haptic
