// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/usb/umock_hidraw.h"

#include <linux/hidraw.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <umockdev.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "proto/os/realtime.h"

namespace haptic::test {
namespace {

constexpr const char* kNode = "/dev/hidraw0";
constexpr const char* kUsb = "/devices/pci0000:00/usb1/1-1";
constexpr uint8_t kIn = 0x81;
constexpr auto kTurn = std::chrono::microseconds(250);  // a quarter of the shortest period

std::string hex(const char* format, unsigned a, unsigned b = 0) {
  char text[64];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

/// The address of the interrupt OUT endpoint; 0: reports go out by SET_REPORT.
uint8_t out_endpoint(const UsbBytes& configuration) {
  constexpr uint8_t kEndpoint = 5, kToHost = 0x80;
  for (size_t i = 0; i + 2 < configuration.size() && configuration[i] > 0; i += configuration[i]) {
    const uint8_t address = configuration[i + 2];
    if (configuration[i + 1] == kEndpoint && (address & kToHost) == 0) return address;
  }
  return 0;
}

void check(bool good, GError* error) {
  if (good) return;
  const std::string why = error != nullptr ? error->message : "no reason given";
  g_clear_error(&error);
  throw std::runtime_error("umockdev: " + why + "; run the test below umockdev-wrapper");
}

}  // namespace

UmockHidraw::UmockHidraw(EmulatedUsb& device) : device_(device) {
  testbed_ = umockdev_testbed_new();
  if (umockdev_in_mock_environment() == FALSE) check(false, nullptr);
  calls_ = umockdev_ioctl_base_new();
  g_signal_connect(calls_, "handle-ioctl", G_CALLBACK(on_ioctl), this);
  g_signal_connect(calls_, "handle-read", G_CALLBACK(on_read), this);
  g_signal_connect(calls_, "handle-write", G_CALLBACK(on_write), this);
  GError* error = nullptr;
  check(umockdev_testbed_attach_ioctl(testbed_, kNode, calls_, &error) != FALSE, error);
  add_to_sysfs();
  terminal_ = umockdev_testbed_get_dev_fd(testbed_, kNode);
  termios raw{};
  tcgetattr(terminal_, &raw);
  cfmakeraw(&raw);
  tcsetattr(terminal_, TCSANOW, &raw);
  thread_ = std::thread([this] { run(); });
}

UmockHidraw::~UmockHidraw() {
  ending_ = true;
  thread_.join();
  GError* error = nullptr;
  umockdev_testbed_detach_ioctl(testbed_, kNode, &error);
  g_clear_error(&error);
  g_object_unref(calls_);
  g_object_unref(testbed_);
}

void UmockHidraw::add_to_sysfs() {
  const UsbDescriptors& d = device_.descriptors();
  const auto text = [&](size_t i) { return i < d.strings.size() ? d.strings[i] : std::string(); };
  const std::string hid = hex("0003:%04X:%04X", d.vendor, d.product) + ".0001";
  sysfs_ = std::string(kUsb) + "/1-1:1.0/" + hid + "/hidraw/hidraw0";
  std::string report;
  for (const uint8_t byte : d.hid_report) report += hex("%02x", byte);
  std::string all = "P: " + std::string(kUsb) +
                    "\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nE: BUSNUM=001\nE: DEVNUM=002\n"
                    "A: idVendor=" +
                    hex("%04x", d.vendor) + "\\n\nA: idProduct=" + hex("%04x", d.product) +
                    "\\n\nA: manufacturer=" + text(0) + "\\n\nA: product=" + text(1) + "\\n\n";
  if (!text(2).empty()) all += "A: serial=" + text(2) + "\\n\n";
  all += "\nP: " + std::string(kUsb) +
         "/1-1:1.0\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_interface\nA: bInterfaceNumber=00\\n\n\nP: " +
         kUsb + "/1-1:1.0/" + hid +
         "\nE: SUBSYSTEM=hid\nE: HID_ID=" + hex("0003:%08X:%08X", d.vendor, d.product) +
         "\nE: HID_NAME=" + text(1) + "\nE: HID_UNIQ=" + text(2) +
         "\nE: HID_PHYS=usb-1/input0\nH: report_descriptor=" + report + "\n\nP: " + sysfs_ +
         "\nN: hidraw0\nE: SUBSYSTEM=hidraw\nE: DEVNAME=" + kNode + "\n";
  GError* error = nullptr;
  check(umockdev_testbed_add_from_string(testbed_, all.c_str(), &error) != FALSE, error);
}

/// The reports come whether or not somebody reads; the kernel drops what is too many.
void UmockHidraw::run() {
  while (!ending_) {
    std::this_thread::sleep_for(kTurn);
    const std::lock_guard lock(mutex_);
    UsbBytes report;
    while (!gone_ && device_.give(kIn, 64, report, now_ns())) {
      if (reports_.size() >= kKernelQueue) continue;
      reports_.push_back(report);
      if (::write(terminal_, "r", 1) != 1) gone_ = true;
    }
  }
}

void UmockHidraw::unplug() {
  const std::lock_guard lock(mutex_);
  gone_ = true;
  umockdev_testbed_uevent(testbed_, ("/sys" + sysfs_).c_str(), "remove");
  umockdev_testbed_remove_device(testbed_, ("/sys" + std::string(kUsb)).c_str());
  close(terminal_);  // hangs up whoever polls
}

int UmockHidraw::on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, void* self) {
  const UsbDescriptors& d = static_cast<UmockHidraw*>(self)->device_.descriptors();
  const UsbBytes& report = d.hid_report;
  UMockdevIoctlData* argument = umockdev_ioctl_client_get_arg(client);
  const auto at = [&](size_t size) {
    return umockdev_ioctl_data_resolve(argument, 0, size, nullptr)->data;
  };
  const auto request = umockdev_ioctl_client_get_request(client);
  if (request == HIDIOCGRDESCSIZE) {
    const int size = static_cast<int>(report.size());
    std::memcpy(at(sizeof size), &size, sizeof size);
  } else if (request == HIDIOCGRDESC) {
    hidraw_report_descriptor all{};
    all.size = static_cast<uint32_t>(report.size());
    std::copy(report.begin(), report.end(), all.value);
    std::memcpy(at(sizeof all), &all, sizeof all);
  } else if (request == HIDIOCGRAWINFO) {
    const hidraw_devinfo info{3, static_cast<int16_t>(d.vendor), static_cast<int16_t>(d.product)};
    std::memcpy(at(sizeof info), &info, sizeof info);
  } else {
    return FALSE;
  }
  umockdev_ioctl_client_complete(client, 0, 0);
  return TRUE;
}

int UmockHidraw::on_read(UMockdevIoctlBase*, UMockdevIoctlClient* client, void* self) {
  auto& node = *static_cast<UmockHidraw*>(self);
  int error = 0;
  const int taken = static_cast<int>(umockdev_ioctl_client_execute(client, &error, nullptr));
  const std::lock_guard lock(node.mutex_);
  if (node.gone_ || taken <= 0 || node.reports_.empty()) {
    const bool gone = node.gone_ || taken == 0;
    umockdev_ioctl_client_complete(client, -1, gone ? ENODEV : EAGAIN);
    return TRUE;
  }
  UsbBytes report = node.reports_.front();
  node.reports_.pop_front();
  // a read takes one report, but as many bytes as it has room for: those of the others go back
  for (int i = 1; i < taken; ++i) {
    if (::write(node.terminal_, "r", 1) != 1) node.gone_ = true;
  }
  UMockdevIoctlData* buffer = umockdev_ioctl_client_get_arg(client);
  umockdev_ioctl_data_update(buffer, 0, report.data(), static_cast<int>(report.size()));
  umockdev_ioctl_client_complete(client, static_cast<long>(report.size()), 0);
  return TRUE;
}

int UmockHidraw::on_write(UMockdevIoctlBase*, UMockdevIoctlClient* client, void* self) {
  auto& node = *static_cast<UmockHidraw*>(self);
  UMockdevIoctlData* argument = umockdev_ioctl_client_get_arg(client);
  const auto size = static_cast<size_t>(argument->data_len);
  const std::lock_guard lock(node.mutex_);
  if (node.gone_ || size == 0) {
    umockdev_ioctl_client_complete(client, -1, node.gone_ ? ENODEV : EINVAL);
    return TRUE;
  }
  // number 0 stands for a device that does not number its reports, and is not sent
  const size_t skipped = argument->data[0] == 0 ? 1 : 0;
  const UsbBytes report(argument->data + skipped, argument->data + size);
  const uint8_t endpoint = out_endpoint(node.device_.descriptors().configuration);
  if (endpoint != 0) {
    node.device_.take(endpoint, report.data(), report.size(), now_ns());
  } else {
    UsbBytes none;
    const auto number = static_cast<uint16_t>(0x200 + argument->data[0]);
    node.device_.control({0x21, 9, number, 0, static_cast<uint16_t>(report.size())}, report, none,
                         now_ns());
  }
  umockdev_ioctl_client_complete(client, static_cast<long>(size), 0);
  return TRUE;
}

}  // namespace haptic::test
