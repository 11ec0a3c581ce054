// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/plugged/send_release.h"

#include <sys/ioctl.h>
// after it: the macros of the requests
#include <linux/usbdevice_fs.h>
#include <unistd.h>

#include <algorithm>
#include <array>

namespace haptic {
namespace {

bool send_bulk(int node, const DeviceRelease& release, size_t size) noexcept {
  unsigned interface = release.interface;
  // fails where nothing is claimed, which is as good
  ioctl(node, USBDEVFS_RELEASEINTERFACE, &interface);
  if (ioctl(node, USBDEVFS_CLAIMINTERFACE, &interface) != 0) return false;
  std::array<char, 64> bytes = release.bytes;
  usbdevfs_bulktransfer transfer{};
  transfer.ep = release.endpoint;
  transfer.len = static_cast<unsigned>(size);
  transfer.timeout = kReleaseWaitMs;
  transfer.data = bytes.data();
  return ioctl(node, USBDEVFS_BULK, &transfer) == static_cast<int>(size);
}

}  // namespace

bool send_release(int node, const DeviceRelease& release) noexcept {
  const size_t size = std::min<size_t>(release.size, release.bytes.size());
  if (node < 0 || size == 0) return false;
  switch (static_cast<ReleaseBy>(release.by)) {
    case ReleaseBy::kWrite:
    case ReleaseBy::kHidReport:
      return write(node, release.bytes.data(), size) > 0;
    case ReleaseBy::kUsbBulk:
      return send_bulk(node, release, size);
    case ReleaseBy::kNone:
      break;
  }
  return false;
}

}  // namespace haptic
