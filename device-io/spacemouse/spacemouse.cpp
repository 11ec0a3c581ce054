// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/spacemouse/spacemouse.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <memory>
#include <utility>

#include "device-io/plugged/find_node.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr int64_t kLongestStepNs = 20'000'000;  // after a stall the handle does not jump

/// Reports of a nonblocking hidraw node, one a call: what hidapi does too, but over the descriptor
/// that the guard of the tests knows, and without a message, which hidapi allocates, about a device
/// that has gone.
NextReport reports_of(FileDescriptor node) {
  auto kept = std::make_shared<FileDescriptor>(std::move(node));
  return [kept](std::span<uint8_t> report) {
    const ssize_t n = read(kept->get(), report.data(), report.size());
    const bool is_empty = n < 0 && (errno == EAGAIN || errno == EINTR);
    return is_empty ? 0 : n > 0 ? static_cast<int>(n) : -1;
  };
}

}  // namespace

SpaceMouse::SpaceMouse(const DeviceConfig& config, std::string name, NextReport next_report)
    : rate_(config.rate),
      range_{config.workspace_centre_B, config.workspace_radius, config.workspace_rest_B,
             config.workspace_turn},
      name_(std::move(name)),
      next_report_(std::move(next_report)) {
  HAPTIC_ASSERT(next_report_);
  last_.X_BH = {range_.centre_B, range_.rest_B};
}

std::string SpaceMouse::description() const {
  return name_ + ", a rate device of 6 axes, no force";
}

void SpaceMouse::hear(int64_t t_ns) {
  std::array<uint8_t, kSpaceMouseReport> report;
  for (int i = 0; i < kMostReports && !gone_; ++i) {
    const int n = next_report_(report);
    gone_ = n < 0;
    if (n <= 0) break;
    const auto size = std::min(static_cast<size_t>(n), report.size());
    if (hears_) hears_(true, {report.data(), size}, t_ns);
    const SpaceMouseReport kind = take_report({report.data(), size}, input_);
    if (kind == SpaceMouseReport::kAxes) heard_ns_ = t_ns;
    if (kind == SpaceMouseReport::kInvalid) ++rejected_;
  }
  if (gone_ || t_ns - heard_ns_ > kReleasedNs) input_.axes = {};
  if (gone_) input_.buttons = 0;
}

/// The velocity is that of the handle, which at the edge of its range is less than commanded.
void SpaceMouse::move(int64_t t_ns) {
  const int64_t since_ns = started_ ? t_ns - last_.t_ns : 0;
  const double dt = 1e-9 * static_cast<double>(std::min(since_ns, kLongestStepNs));
  const Pose before_B = last_.X_BH;
  last_.X_BH = moved_within(before_B, commanded_velocity(input_, rate_), dt, range_);
  last_.V_BH = {(last_.X_BH.p - before_B.p) / dt,
                to_rotation_vector(last_.X_BH.q * conjugate(before_B.q)) / dt};
}

bool SpaceMouse::read(const TickTime& tick, DeviceState& state) {
  hear(tick.now_ns);
  if (started_ && tick.now_ns > last_.t_ns) move(tick.now_ns);
  if (!started_ || tick.now_ns > last_.t_ns) last_.t_ns = tick.now_ns;
  started_ = true;
  last_.buttons = input_.buttons;
  last_.flags = kDeviceHomed | (gone_ ? kDeviceHeld | kDeviceLost : kDeviceFresh);
  state = last_;
  return !gone_;
}

std::unique_ptr<Device> open_spacemouse(const DeviceConfig& config, FileDescriptor node) {
  if (!node.is_open()) node = open_node(config);
  return std::make_unique<SpaceMouse>(config, "3Dconnexion SpaceMouse",
                                      reports_of(std::move(node)));
}

}  // namespace haptic
