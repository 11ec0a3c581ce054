// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for device-io/plugged/find_node.cpp with devices of umockdev.
#include "device-io/plugged/find_node.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "proto/os/message.h"
#include "tests/support/hostile_text.h"
#include "tests/support/usb/plugged_bed.h"

namespace haptic {
namespace {

using test::BedDevice;
using test::PluggedBed;

// rows of the test's own, so that it holds whatever the table holds
constexpr DeviceRow kBulk{
    .name = "bulk", .id = DeviceKind{}, .node = NodeKind::kUsb, .usb_ids = "0403:cb48 0403:cb49"};
constexpr DeviceRow kReports{.name = "reports",
                             .id = DeviceKind{},
                             .node = NodeKind::kHid,
                             .usb_ids = "1234:0006",
                             .usb_product = "Haptics"};

DeviceConfig choice(const std::string& serial, const std::string& port) {
  DeviceConfig config{};
  assign(config.plugged.serial, serial);
  assign(config.plugged.port, port);
  return config;
}

std::string found(const DeviceRow& row, const std::string& serial = "",
                  const std::string& port = "") {
  return find_node(row, choice(serial, port));
}

/// The message where none is found.
std::string refusal(const DeviceRow& row, const std::string& serial = "",
                    const std::string& port = "") {
  try {
    found(row, serial, port);
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was refused";
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

const BedDevice kFirst{"1-1", "0403", "cb48", "F001", "Novint", "Falcon"};
const BedDevice kSecond{"1-2.3", "0403", "cb49", "F002", "Novint", "Falcon"};

}  // namespace

TEST_CASE("plugged: without devices nothing is listed, and the message says what to plug in") {
  const PluggedBed bed;
  CHECK(list_plugged().empty());
  CHECK(refusal(kBulk) ==
        "no bulk is plugged in; plug it in and switch it on (`hapt devices` lists what is there)");
}

TEST_CASE("plugged: each kind of node is listed with what its USB device says") {
  PluggedBed bed;
  bed.plug_usb(kFirst, "004");
  bed.plug_hid({"1-3", "1234", "0006", "", "mbed", "Haptics"}, "005", "hidraw7");
  bed.plug_serial({"1-4", "16c0", "0483", "T9", "Teensyduino", "USB Serial"}, "006", "ttyACM3");
  const std::vector<PluggedNode> nodes = list_plugged();
  const auto at = [&](const std::string& path) -> PluggedNode {
    const auto node = std::ranges::find(nodes, path, &PluggedNode::path);
    REQUIRE(node != nodes.end());
    return *node;
  };
  // a HID and a serial device have their USB node, too
  CHECK(nodes.size() == 5);
  CHECK(std::ranges::is_sorted(nodes, {}, &PluggedNode::path));

  const PluggedNode falcon = at("/dev/bus/usb/001/004");
  CHECK(falcon.kind == NodeKind::kUsb);
  CHECK(falcon.vendor == 0x0403);
  CHECK(falcon.product == 0xcb48);
  CHECK(falcon.serial == "F001");
  CHECK(falcon.port == "1-1");
  CHECK(falcon.manufacturer == "Novint");
  CHECK(falcon.name == "Falcon");

  const PluggedNode reports = at("/dev/hidraw7");
  CHECK(reports.kind == NodeKind::kHid);
  CHECK(reports.vendor == 0x1234);
  CHECK(reports.serial.empty());
  CHECK(reports.port == "1-3");
  const PluggedNode serial = at("/dev/ttyACM3");
  CHECK(serial.kind == NodeKind::kSerial);
  CHECK(serial.product == 0x0483);
  CHECK(serial.serial == "T9");
}

TEST_CASE("plugged: one device is found whatever else is there, also by its numbers") {
  PluggedBed bed;
  bed.plug_usb(kFirst, "004");
  bed.plug_usb({"1-5", "0403", "6001", "X", "FTDI", "Falcon"}, "009");
  bed.plug_hid({"1-3", "1234", "0006", "", "mbed", "Haptics arm"}, "005", "hidraw0");
  CHECK(found(kBulk) == "/dev/bus/usb/001/004");
  CHECK(found(kBulk, "F001") == "/dev/bus/usb/001/004");
  CHECK(found(kBulk, "", "1-1") == "/dev/bus/usb/001/004");
  CHECK(found(kReports) == "/dev/hidraw0");
}

TEST_CASE("plugged: two devices of a kind are told apart by serial number or port") {
  PluggedBed bed;
  bed.plug_usb(kFirst, "004");
  bed.plug_usb(kSecond, "005");
  CHECK(found(kBulk, "F001") == "/dev/bus/usb/001/004");
  CHECK(found(kBulk, "F002") == "/dev/bus/usb/001/005");
  CHECK(found(kBulk, "", "1-2.3") == "/dev/bus/usb/001/005");
  const std::string several = refusal(kBulk);
  INFO(several);
  CHECK(has(several, "several devices may be the bulk"));
  CHECK(has(several, "/dev/bus/usb/001/004 (port 1-1, serial F001)"));
  CHECK(has(several, "/dev/bus/usb/001/005 (port 1-2.3, serial F002)"));
  CHECK(has(several, "'serial' or 'port' in [device.usb]"));
  // a number of the one and a port of the other
  CHECK(has(refusal(kBulk, "F001", "1-2.3"), "with that 'serial' and 'port'"));
  CHECK(has(refusal(kBulk, "F0"), "with that 'serial' and 'port'"));
}

TEST_CASE("plugged: two devices without serial number, or with the same, by port alone") {
  const std::string number = GENERATE("", "0001");
  PluggedBed bed;
  bed.plug_hid({"1-1", "1234", "0006", number, "mbed", "Haptics"}, "004", "hidraw0");
  bed.plug_hid({"1-2", "1234", "0006", number, "mbed", "Haptics"}, "005", "hidraw1");
  CHECK(found(kReports, "", "1-1") == "/dev/hidraw0");
  CHECK(found(kReports, "", "1-2") == "/dev/hidraw1");
  CHECK(has(refusal(kReports, number), "several devices may be the reports"));
}

TEST_CASE("plugged: the ids of an experiment are not enough, the product's name decides") {
  PluggedBed bed;
  bed.plug_hid({"1-1", "1234", "0006", "", "somebody", "Garden lamp"}, "004", "hidraw0");
  CHECK(has(refusal(kReports), "no reports is plugged in; plug it in"));
}

TEST_CASE("plugged: texts of a device cannot change what a terminal shows") {
  // the kernel turns the UTF-16 of the device into UTF-8
  const std::string text = GENERATE("\x1b[2J\x1b[31mF", "gnp.\u202eexe", "\u009b31m");
  PluggedBed bed;
  bed.plug_usb({"1-1", "0403", "cb48", text, text, text}, "004");
  bed.plug_usb({"1-2", "0403", "cb48", text, text, text}, "005");
  REQUIRE(list_plugged().size() == 2);
  CHECK(list_plugged()[0].serial == text);
  const std::string several = refusal(kBulk);
  CHECK(has(several, "several devices"));
  CHECK(printable(several, several.size()) == several);
}

TEST_CASE("plugged: a device that is unplugged is gone, and is found at the node of its return") {
  PluggedBed bed;
  bed.plug_usb(kFirst, "004");
  bed.plug_usb(kSecond, "005");
  bed.unplug(kFirst);
  CHECK(found(kBulk) == "/dev/bus/usb/001/005");
  CHECK(has(refusal(kBulk, "F001"), "no bulk is plugged in with that"));
  bed.plug_usb(kFirst, "017");
  CHECK(found(kBulk, "F001") == "/dev/bus/usb/001/017");
  BedDevice elsewhere = kFirst;
  bed.unplug(kFirst);
  elsewhere.port = "1-4";
  bed.plug_usb(elsewhere, "018");
  CHECK(found(kBulk, "F001") == "/dev/bus/usb/001/018");
}

TEST_CASE("plugged: a node that is gone or forbidden is refused with a mend") {
  const auto message = [](NodeKind kind, const std::string& path) -> std::string {
    try {
      open_node(kind, path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "it was opened";
  };
  CHECK(message(NodeKind::kUsb, "/dev/bus/usb/001/099") ==
        "/dev/bus/usb/001/099: cannot be opened: No such file or directory; plug the device in "
        "again");
  CHECK(has(message(NodeKind::kHid, "/dev/hidraw99"), "plug the device in again"));
}

}  // namespace haptic
