// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/selftest/guarded_loop.h"

#include <sys/mman.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <exception>
#include <memory>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "device-io/plugged/find_node.h"
#include "proto/config/devices.h"
#include "proto/ipc/control.h"
#include "proto/os/priorities.h"
#include "servo/loop.h"
#include "sim/step.h"

namespace haptic {
namespace {

constexpr uint64_t kGeneration = 1;  // of each segment: nothing is restarted here
constexpr int64_t kAttachPatienceNs = 10 * kNsPerSecond;  // until every segment is attached
constexpr int64_t kLookNs = 1'000'000;     // [ns]; between two looks at the attachments
constexpr uint64_t kControlPeriod = 3000;  // ticks between two changes of the controls
constexpr double kSofter = 0.8;            // factor of the stiffness, every other change

std::array<FileDescriptor, 2> make_socket_pair() {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) {
    throw std::system_error(errno, std::generic_category(), "socketpair");
  }
  return {FileDescriptor(ends[0]), FileDescriptor(ends[1])};
}

/// The three processes of a session and hapticd's controls, each with its own segment.
class OneThreadSession {
 public:
  OneThreadSession(const SessionConfig& config, const ContactShapes& shapes, GuardedDevice device)
      : sockets_(make_socket_pair()),
        attachments_(std::move(sockets_[1])),
        inbox_(attachments_),
        device_(std::move(device)),
        loop_(config, *device_.device, inbox_, servo_.channels()),
        contact_model_(build_contact_model(config, shapes)),
        contact_state_(contact_model_),
        sim_model_(build_sim(config, shapes.objects, shapes.collision_pieces)),
        control_(initial_control(config)),
        period_ns_(period_ns(config.servo_rate)),
        sim_period_ns_(period_ns(config.sim_rate)),
        next_ns_(now_ns()),
        next_scene_ns_(next_ns_) {
    offer(contact_);
    offer(sim_);
    offer(controls_);
    attachments_.start();
    controls_.channels().frames.publish(control_);
    move_scene(next_ns_);
    contact_.channels().sets.publish({});
    const int64_t give_up_ns = now_ns() + kAttachPatienceNs;
    while (!everything_arrives()) {
      if (now_ns() > give_up_ns) throw std::runtime_error("the segments were not attached");
      sleep_until(now_ns() + kLookNs);
    }
  }

  /// Leaves the device without force.
  ~OneThreadSession() { loop_.stop(); }

  const GuardedDevice& device() const { return device_; }

  /// One tick on virtual time.
  void tick() { tick({next_index_, next_ns_, 0, 0}); }

  /// One tick on the clock, with its deadline moved to virtual time.
  void tick(DeadlineClock& clock) {
    const Tick real = clock.wait();
    // a device must not hear of an earlier instant than before
    next_ns_ += static_cast<int64_t>(real.skipped) * period_ns_;
    tick({next_index_, next_ns_, real.late_ns, real.skipped});
  }

  const ServoFrame& frame() const { return loop_.frame(); }

 private:
  template <typename Channels>
  void offer(SegmentWriter<Channels>& segment) {
    offer_segment(sockets_[0].get(), Channels::kId, kGeneration, Channels::kName, segment.fd());
  }

  bool everything_arrives() {
    ServoInput input;
    inbox_.receive(input);
    return inbox_.any_contact && inbox_.scenes.any() && inbox_.any_control;
  }

  void tick(const Tick& tick) {
    if (tick.deadline_ns >= next_scene_ns_) move_scene(tick.deadline_ns);
    if (tick.index % kControlPeriod == 0) change_controls();
    servo_.beat(tick.index, tick.deadline_ns);
    loop_.tick(tick);
    contact_.channels().sets.publish(
        contact_step(contact_model_, contact_state_, loop_.frame(), &scene_));
    ++next_index_;
    next_ns_ += period_ns_;
  }

  void move_scene(int64_t t_ns) {
    scene_ = sim_step(sim_model_, sim_state_, {&loop_.frame()}, t_ns);
    sim_.channels().frames.publish(scene_);
    next_scene_ns_ = t_ns + sim_period_ns_;
  }

  void change_controls() {
    ControlFrame changed = control_;
    changed.revision = ++revision_;
    if (revision_ % 2 == 0) changed.translational_stiffness *= kSofter;
    controls_.channels().frames.publish(changed);
  }

  SegmentWriter<ServoChannels> servo_{kGeneration};
  SegmentWriter<ContactChannels> contact_{kGeneration};
  SegmentWriter<SimChannels> sim_{kGeneration};
  SegmentWriter<ControlChannels> controls_{kGeneration};
  std::array<FileDescriptor, 2> sockets_;
  Attachments attachments_;
  ServoInbox inbox_;
  GuardedDevice device_;
  ServoLoop loop_;
  ContactModel contact_model_;
  ContactState contact_state_;
  SimModel sim_model_;
  SimState sim_state_{sim_model_};
  SceneFrame scene_{};
  ControlFrame control_;
  uint64_t revision_ = 1;
  int64_t period_ns_;
  int64_t sim_period_ns_;
  int64_t next_ns_;
  int64_t next_scene_ns_;
  uint64_t next_index_ = 0;
};

/// Runs on the guarded thread: rights, warm-up, then the guarded ticks.
void run_armed(OneThreadSession& session, const SessionConfig& config,
               const GuardedLoopOptions& options, GuardedLoopResult& result) {
  const bool always_timed = session.device().is_real_time;
  // no FIFO on virtual time: RLIMIT_RTTIME would end a million ticks without a sleep
  result.rights = enter_realtime(
      {.fifo_priority = always_timed && config.realtime ? kServoPriority : 0, .lock_memory = true});
  RtGuard guard({.device_node = session.device().node});
  const int64_t period = period_ns(config.servo_rate);
  DeadlineClock warm_clock(period);
  session.tick(warm_clock);
  for (uint64_t k = 0; k < options.warm_up; ++k) {
    always_timed ? session.tick(warm_clock) : session.tick();
  }

  DeadlineClock clock(period);
  guard.arm();
  for (uint64_t k = 0; k < options.timed_ticks + options.ticks; ++k) {
    const bool is_timed = always_timed || k < options.timed_ticks;
    is_timed ? session.tick(clock) : session.tick();
    if (options.also_do) options.also_do(k);
    result.count(session.frame(), is_timed);
  }
  guard.disarm();
  result.report = guard.report();
}

}  // namespace

GuardedDevice open_guarded(const DeviceConfig& config) {
  FileDescriptor node = open_node(config);
  const int number = node.is_open() ? node.get() : -1;
  return {open_device(config, std::move(node)), number, number >= 0};
}

bool has_node(const DeviceConfig& device) {
  return row_of(device.kind).has_node();
}

void GuardedLoopResult::count(const ServoFrame& frame, bool is_timed) noexcept {
  ++ticks;
  timed_ticks += is_timed;
  contact_ticks += (frame.flags & kServoContact) != 0;
  lost_ticks += (frame.device.flags & kDeviceLost) != 0;
}

GuardedLoopResult run_guarded_loop(const SessionConfig& config, const ContactShapes& shapes,
                                   const GuardedLoopOptions& options) {
  if (!guard_hooks_linked()) {
    throw std::runtime_error(
        "rt_guard has no hooks in this program: sanitizers interpose the same functions; use a dev "
        "or release build");
  }
  const auto session =
      std::make_unique<OneThreadSession>(config, shapes, options.open(config.device));
  GuardedLoopResult result;
  std::exception_ptr failure;
  // its own thread: the system call filter stays until the thread ends
  std::thread([&] {
    try {
      run_armed(*session, config, options, result);
    } catch (...) {
      // rethrown in the caller's thread
      failure = std::current_exception();
    }
  }).join();
  munlockall();
  if (failure) std::rethrow_exception(failure);
  return result;
}

}  // namespace haptic
