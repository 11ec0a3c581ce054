// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <umockdev.h>

#include <atomic>
#include <cstdint>
#include <list>
#include <mutex>
#include <string>

#include "device-io/emulator/emulated_usb.h"

namespace haptic::test {

/// What the kernel's side of a node has seen.
struct UsbfsAccount {
  uint64_t submitted = 0;  // transfers
  uint64_t discarded = 0;  // by USBDEVFS_DISCARDURB
  uint64_t cancelled = 0;  // in flight when their interface was released
  uint64_t claims = 0, releases = 0;
  uint64_t bulks = 0;           // synchronous packets: hapticd's
  uint64_t in_flight_then = 0;  // transfers in flight at the last of them
};

/// An emulated device at /dev/bus/usb/001/NNN, as umockdev shows it to a program that runs below
/// umockdev-wrapper: sysfs, udev, and usbfs with synchronous and asynchronous transfers. It is the
/// node's side only: a device on a wire would be paced by the bus, this one by who asks.
class UmockUsb {
 public:
  /// Plugged in at port 1-`number`, node 001/`number`. `testbed` outlives this.
  UmockUsb(UMockdevTestbed* testbed, EmulatedUsb& device, int number);
  ~UmockUsb();
  UmockUsb(const UmockUsb&) = delete;
  UmockUsb& operator=(const UmockUsb&) = delete;

  /// Transfers in flight end with ENODEV, udev says that it has gone.
  void unplug();
  /// The same device at the same port with a new node.
  void plug(int number);

  UsbfsAccount account();
  /// To be held while the device itself is looked at or changed.
  std::mutex& lock() { return lock_; }
  const std::string& node() const { return node_; }

 private:
  static gboolean handle(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self);
  bool answer(UMockdevIoctlClient* client, unsigned long request, UMockdevIoctlData* argument);
  void submit(UMockdevIoctlData* urb);
  bool control(uint8_t* bytes, int size, int& actual);
  bool standard(const UsbSetup& setup, UsbBytes& in) const;
  void give_waiting();
  bool reap(UMockdevIoctlData* argument);
  bool discard(UMockdevIoctlData* argument);
  void bulk(UMockdevIoctlData* argument);
  void end_all(int status);
  void add();

  UMockdevTestbed* testbed_;
  EmulatedUsb& device_;
  UMockdevIoctlBase* handler_ = nullptr;
  std::mutex lock_;
  std::list<UMockdevIoctlData*> in_flight_, done_;
  UsbfsAccount account_;
  std::string node_, path_, port_;
  int number_;
  bool gone_ = false;
};

}  // namespace haptic::test
