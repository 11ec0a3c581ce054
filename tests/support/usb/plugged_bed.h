// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <umockdev.h>
#include <unistd.h>

#include <stdexcept>
#include <string>

namespace haptic::test {

/// A USB device of a test's /sys and /dev.
struct BedDevice {
  std::string port;  // "1-2.3"
  std::string vendor, product;
  std::string serial{}, manufacturer{}, name{};
};

/// /sys and /dev of a machine whose devices a test plugs in. The program runs below
/// umockdev-wrapper.
class PluggedBed {
 public:
  PluggedBed() : bed_(umockdev_testbed_new()) {
    if (umockdev_in_mock_environment() == 0) throw std::runtime_error("run umockdev-wrapper");
  }
  ~PluggedBed() { g_object_unref(bed_); }
  PluggedBed(const PluggedBed&) = delete;

  /// Where its files lie: read below it what is not read through the C library's calls.
  std::string root() const { return umockdev_testbed_get_root_dir(bed_); }

  /// A USB device and its node; `number` is the last part of the node's path.
  std::string plug_usb(const BedDevice& device, const std::string& number) {
    const std::string node = "bus/usb/001/" + number;
    std::string text = "P: " + place(device) + "\nN: " + node + "\nE: SUBSYSTEM=usb\n" +
                       "E: DEVTYPE=usb_device\nE: DEVNAME=/dev/" + node + "\n";
    const auto attribute = [&](const char* name, const std::string& value) {
      if (!value.empty()) text += std::string("A: ") + name + "=" + value + "\\n\n";
    };
    attribute("idVendor", device.vendor);
    attribute("idProduct", device.product);
    attribute("serial", device.serial);
    attribute("manufacturer", device.manufacturer);
    attribute("product", device.name);
    add(text);
    return "/dev/" + node;
  }

  /// The same and the node of a HID interface.
  std::string plug_hid(const BedDevice& device, const std::string& number,
                       const std::string& node) {
    plug_usb(device, number);
    const std::string hid = interface(device) + "/0003:0000:0000." + number;
    add("P: " + hid + "\nE: SUBSYSTEM=hid\n");
    add("P: " + hid + "/hidraw/" + node + "\nN: " + node +
        "\nE: SUBSYSTEM=hidraw\nE: DEVNAME=/dev/" + node + "\n");
    return "/dev/" + node;
  }

  /// The same and the node of a serial line.
  std::string plug_serial(const BedDevice& device, const std::string& number,
                          const std::string& node) {
    plug_usb(device, number);
    add("P: " + interface(device) + "/tty/" + node + "\nN: " + node +
        "\nE: SUBSYSTEM=tty\nE: DEVNAME=/dev/" + node + "\n");
    return "/dev/" + node;
  }

  void unplug(const BedDevice& device) {
    umockdev_testbed_remove_device(bed_, sys(device).c_str());
  }

  /// The same, and its node hangs up on who has it open.
  void unplug_hid(const BedDevice& device, const std::string& node) {
    close(umockdev_testbed_get_dev_fd(bed_, ("/dev/" + node).c_str()));
    unplug(device);
  }

  /// Adds devices in umockdev's own words.
  void add(const std::string& text) {
    GError* error = nullptr;
    if (umockdev_testbed_add_from_string(bed_, text.c_str(), &error)) return;
    const std::string why = error->message;
    g_error_free(error);
    throw std::runtime_error("no such bed: " + why + "\n" + text);
  }

 private:
  static std::string place(const BedDevice& device) {
    return "/devices/pci0000:00/usb1/" + device.port;
  }
  static std::string sys(const BedDevice& device) { return "/sys" + place(device); }
  std::string interface(const BedDevice& device) {
    const std::string path = place(device) + "/" + device.port + ":1.0";
    add("P: " + path + "\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_interface\n");
    return path;
  }

  UMockdevTestbed* bed_;
};

}  // namespace haptic::test
