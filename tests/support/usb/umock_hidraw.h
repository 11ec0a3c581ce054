// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "device-io/emulator/emulated_usb.h"

typedef struct _UMockdevTestbed UMockdevTestbed;
typedef struct _UMockdevIoctlBase UMockdevIoctlBase;
typedef struct _UMockdevIoctlClient UMockdevIoctlClient;

namespace haptic::test {

/// An emulated HID device at /dev/hidraw0, in real time, for programs below umockdev-wrapper: its
/// entries of sysfs, its ioctls, and packets of one report each. There is no kernel behind it: what
/// hid-generic or hid-logitech would do is not tested.
///
/// poll() of a node reaches umockdev's pseudo-terminal, not this: one byte there for each report
/// wakes it, and is taken away when the report is read.
class UmockHidraw {
 public:
  explicit UmockHidraw(EmulatedUsb& device);
  ~UmockHidraw();
  UmockHidraw(const UmockHidraw&) = delete;
  UmockHidraw& operator=(const UmockHidraw&) = delete;

  /// Readers hang up, and the node is gone from sysfs.
  void unplug();

  /// Runs `look` while no call to the device is under way.
  template <typename Look>
  auto with_device(Look look) {
    const std::lock_guard lock(mutex_);
    return look();
  }

 private:
  static int on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, void* self);
  static int on_read(UMockdevIoctlBase*, UMockdevIoctlClient* client, void* self);
  static int on_write(UMockdevIoctlBase*, UMockdevIoctlClient* client, void* self);
  void add_to_sysfs();
  void run();

  static constexpr size_t kKernelQueue = 64;  // HIDRAW_BUFFER_SIZE
  EmulatedUsb& device_;
  UMockdevTestbed* testbed_ = nullptr;
  UMockdevIoctlBase* calls_ = nullptr;
  std::string sysfs_;
  int terminal_ = -1;
  std::mutex mutex_;
  std::deque<UsbBytes> reports_;
  std::atomic<bool> ending_{false}, gone_{false};
  std::thread thread_;
};

}  // namespace haptic::test
