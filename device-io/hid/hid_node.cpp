// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/hid/hid_node.h"

#include <hidapi/hidapi.h>

#include "proto/ipc/process.h"

namespace haptic {

void HidNode::Close::operator()(hid_device_* device) const {
  hid_close(device);
}

HidNode::HidNode(const std::string& path) {
  if (hid_init() != 0) throw DeviceError("hidapi does not begin; is /sys mounted?");
  device_.reset(hid_open_path(path.c_str()));
  if (device_) return;
  throw DeviceError(path +
                    ": cannot be opened; plug the device out and in again, and see `hapt doctor`");
}

HidNode::~HidNode() = default;

int HidNode::read(std::span<uint8_t> report, int wait_ms) {
  return hid_read_timeout(device_.get(), report.data(), report.size(), wait_ms);
}

bool HidNode::write(std::span<const uint8_t> report) {
  return hid_write(device_.get(), report.data(), report.size()) == static_cast<int>(report.size());
}

}  // namespace haptic
