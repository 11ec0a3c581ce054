// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/device_guard.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <memory>
#include <stdexcept>

#include "device-io/plugged/find_node.h"
#include "device-io/plugged/send_release.h"
#include "proto/math/units.h"
#include "proto/os/priorities.h"
#include "proto/os/realtime.h"
#include "servo/hapticd/restart_policy.h"

namespace haptic {
namespace {

constexpr int64_t kLookNs = 2 * kMs;        // longest period of the checks
constexpr int64_t kHeldUpNs = 3 * kMs;      // a check later than this is skipped
constexpr int64_t kLetGoNs = 50 * kMs;      // for the thread to take what is handed over
constexpr int64_t kTryAgainNs = 200 * kMs;  // between attempts to reopen a missing device

FileDescriptor duplicate(const FileDescriptor& fd) {
  return FileDescriptor(fd.is_open() ? fcntl(fd.get(), F_DUPFD_CLOEXEC, 0) : -1);
}

}  // namespace

bool ReleaseSchedule::is_due(bool helpless, int64_t t_ns) {
  if (!helpless) sent_ = 0;
  if (!helpless || sent_ == kTimes || (sent_ > 0 && t_ns < next_ns_)) return false;
  ++sent_;
  next_ns_ = t_ns + kApartNs;
  return true;
}

DeviceGuard::DeviceGuard(const SessionConfig& config, Attachments& attachments)
    : device_(config.device),
      path_(find_node(device_)),
      period_ns_(period_ns(config.servo_rate)),
      realtime_(config.realtime != 0),
      node_(open_node(row_of(device_.kind).node, path_)),
      offered_(attachments.ring<&ServoChannels::releases>(Start::kOldest, config.hand)) {}

DeviceGuard::~DeviceGuard() {
  ending_ = true;
  if (thread_.joinable()) thread_.join();
  delete next_.exchange(nullptr);
}

void DeviceGuard::start() {
  thread_ = std::thread([this] { run(); });
}

int DeviceGuard::node_for_servo() {
  const NodeKind kind = row_of(device_.kind).node;
  if (kind != NodeKind::kUsb || generation_ == 0 || !node_.is_open()) return node_.get();
  node_ = {};
  hand_over();
  const timespec turn{0, kMs};
  for (int64_t waited_ns = 0; next_.load() != nullptr && waited_ns < kLetGoNs; waited_ns += kMs) {
    nanosleep(&turn, nullptr);
  }
  try_again_ns_ = 0;  // for look(), should it be gone
  node_ = open_node(kind, path_);
  return node_.get();
}

void DeviceGuard::watch(int pidfd, uint64_t generation) {
  pidfd_ = FileDescriptor(fcntl(pidfd, F_DUPFD_CLOEXEC, 0));
  generation_ = generation;
  hand_over();
}

/// Lock-free: the thread takes the newest; one it has not taken is deleted here.
void DeviceGuard::hand_over() {
  auto watched =
      std::make_unique<Watched>(Watched{duplicate(node_), duplicate(pidfd_), generation_});
  delete next_.exchange(watched.release());
}

DeviceGuard::Change DeviceGuard::look(int64_t t_ns) {
  if (node_.is_open()) {
    pollfd hung_up{node_.get(), 0, 0};
    if (poll(&hung_up, 1, 0) <= 0) return Change::kNone;
    node_ = {};
    hand_over();
    return Change::kGone;
  }
  if (t_ns < try_again_ns_) return Change::kNone;
  try_again_ns_ = t_ns + kTryAgainNs;
  try {
    // a USB device comes back as another node
    path_ = find_node(device_);
    node_ = open_node(row_of(device_.kind).node, path_);
  } catch (const std::runtime_error&) {
    return Change::kNone;  // not back yet
  }
  hand_over();
  return Change::kBack;
}

bool DeviceGuard::is_helpless(const Watched& watched, int64_t t_ns) noexcept {
  pollfd ended{watched.pidfd.get(), POLLIN, 0};
  if (watched.pidfd.is_open() && poll(&ended, 1, 0) > 0) return true;
  const SegmentHeader* header = offered_.header();
  // before its loop runs a servo holds zero force itself
  return runs(header, watched.generation) &&
         t_ns - header->heartbeat_ns.load() > kReleaseAfterTicks * period_ns_;
}

void DeviceGuard::run() {
  // without locked memory: pages used every 2 ms stay resident, and a process with tens of
  // megabytes locked takes tens of milliseconds to die before its children notice
  enter_realtime({.fifo_priority = realtime_ ? kGuardPriority : 0, .lock_memory = false});
  const int64_t look_ns = std::min(kLookNs, 2 * period_ns_);
  auto watched = std::make_unique<Watched>();
  ReleaseSchedule schedule;
  bool helpless = false;
  for (int64_t looked_ns = now_ns(); !ending_;) {
    // wakes at the servo's end; not again, since its pidfd stays readable
    pollfd ended{helpless ? -1 : watched->pidfd.get(), POLLIN, 0};
    const timespec wait{0, look_ns};
    ppoll(&ended, 1, &wait, nullptr);
    if (Watched* next = next_.exchange(nullptr); next != nullptr) {
      watched.reset(next);
      // the previous servo is dead, perhaps since the last check
      send_release(watched->node.get(), release_);
      schedule = {};
    }
    offered_.latest(release_);
    const int64_t t_ns = now_ns();
    const bool held_up = t_ns - looked_ns > look_ns + kHeldUpNs;
    looked_ns = t_ns;
    if (held_up) continue;
    helpless = is_helpless(*watched, t_ns);
    if (schedule.is_due(helpless, t_ns) && send_release(watched->node.get(), release_))
      releases_.fetch_add(1);
  }
}

}  // namespace haptic
