// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for clients/desk/device_list.cpp on nodes of the test's own.
#include "clients/desk/device_list.h"

#include <catch2/catch.hpp>
#include <sstream>

#include "proto/os/message.h"
#include "tests/support/hostile_text.h"

namespace haptic {
namespace {

constexpr DeviceKind id(uint32_t number) {
  return static_cast<DeviceKind>(number);
}
constexpr std::array kRows{
    DeviceRow{.name = "hand", .id = id(0)},
    DeviceRow{.name = "text-line", .id = id(1), .node = NodeKind::kSerial},
    DeviceRow{.name = "other-line", .id = id(2), .node = NodeKind::kSerial},
    DeviceRow{.name = "delta", .id = id(3), .node = NodeKind::kUsb, .usb_ids = "0403:cb48"},
    DeviceRow{.name = "arm",
              .id = id(4),
              .node = NodeKind::kHid,
              .usb_ids = "1234:0006",
              .usb_product = "Haptics",
              .tried = true}};

const PluggedNode kDelta{
    NodeKind::kUsb, "/dev/bus/usb/001/004", 0x0403, 0xcb48, "F001", "1-1", "Novint", "Falcon"};
const PluggedNode kArm{NodeKind::kHid, "/dev/hidraw0", 0x1234,   0x0006, "",
                       "1-2",          "mbed",         "Haptics"};
const PluggedNode kLine{NodeKind::kSerial,
                        "/dev/ttyACM0",
                        0x16c0,
                        0x0483,
                        "9",
                        "1-3",
                        "Teensyduino",
                        "USB Serial",
                        "/dev/serial/by-id/usb-Teensyduino_USB_Serial_9-if00"};
const PluggedNode kMouse{NodeKind::kHid, "/dev/hidraw1", 0x046d, 0xc077, "",
                         "1-4",          "Logitech",     "Mouse"};
constexpr NodeAccess open_to_all() {
  return {.exists = true, .allowed = true};
}

std::string listed(std::vector<PluggedNode> nodes, bool json = false) {
  std::vector<ListedDevice> devices = supported(kRows, nodes);
  for (ListedDevice& device : devices) device.access = open_to_all();
  std::ostringstream out;
  (json ? print_devices_json : print_devices)(kRows, devices, out);
  return out.str();
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("device list: of all nodes those that a row may drive") {
  const auto devices = supported(kRows, {kMouse, kDelta, kArm, kLine});
  REQUIRE(devices.size() == 3);
  CHECK(devices[0].rows.size() == 1);
  CHECK(devices[0].rows[0].name == "delta");
  CHECK(devices[1].rows[0].name == "arm");
  REQUIRE(devices[2].rows.size() == 2);
  CHECK(devices[2].rows[0].name == "text-line");
  CHECK(devices[2].rows[1].name == "other-line");
  // the USB node of a HID device is not another device
  PluggedNode under_arm = kArm;
  under_arm.kind = NodeKind::kUsb;
  CHECK(supported(kRows, {under_arm}).empty());
}

TEST_CASE("device list: a stranger sees what it is, whether it opens, and what to write") {
  const std::string text = listed({kDelta, kArm});
  INFO(text);
  CHECK(has(text,
            "  delta              0403:cb48 Novint \"Falcon\", serial number F001, port 1-1, "
            "/dev/bus/usb/001/004\n"
            "                     emulated only, not yet tried on hardware\n"
            "                     can be opened\n"
            "                     config:  [device]\n"
            "                              kind = \"delta\"\n"
            "                              [device.usb]  # only where several are plugged in\n"
            "                              serial = \"F001\"\n"));
  CHECK(has(text, "tried on hardware\n"));
  CHECK(has(text, "port = \"1-2\""));  // without a serial number
  CHECK(has(text,
            "supported besides:\n  hand               no hardware needed\n  text-line          "));
  CHECK_FALSE(has(text.substr(text.find("besides")), "delta"));
}

TEST_CASE("device list: a serial port is named by its lasting path and by all it may be") {
  const std::string text = listed({kLine});
  CHECK(has(text, "may be any of: text-line, other-line (the config says which)"));
  CHECK(has(text, "kind = \"text-line\"  # or other-line\n"));
  CHECK(has(text, "path = \"/dev/serial/by-id/usb-Teensyduino_USB_Serial_9-if00\""));
  PluggedNode plain = kLine;
  plain.link.clear();
  CHECK(has(listed({plain}), "path = \"/dev/ttyACM0\""));
}

TEST_CASE("device list: the ids of a row with another product are said to be no such device") {
  PluggedNode lamp = kArm;
  lamp.name = "Garden lamp";
  const std::string text = listed({lamp});
  CHECK(has(text, "has the ids of arm, whose product's name holds \"Haptics\": not driven"));
  CHECK(has(text.substr(text.find("besides")), "  arm "));
  CHECK(has(listed({lamp}, true), "\"kinds\": []"));
}

TEST_CASE("device list: texts of a device stay one line of printable characters") {
  for (const std::string& hostile : test::kHostileTexts) {
    PluggedNode node = kDelta;
    node.serial = node.manufacturer = node.name = node.port = hostile;
    const std::string text = listed({node}), plain = listed({kDelta});
    CHECK(lines_of(text).size() == lines_of(plain).size());
    for (const std::string& line : lines_of(text)) {
      CHECK(printable(line, line.size() + 40) == line);
    }
    const std::string json = listed({node}, true);
    CHECK(lines_of(json).size() == lines_of(listed({kDelta}, true)).size());
    CHECK_FALSE(has(json, "\x1b"));
  }
}

TEST_CASE("device list: JSON has an object for each device and each row without one") {
  const std::string json = listed({kDelta, kLine}, true);
  INFO(json);
  CHECK(has(json,
            "[\n  {\"plugged\": true, \"kinds\": [\"delta\"], \"tried\": false, \"node\": "
            "\"USB\", \"path\": \"/dev/bus/usb/001/004\", \"ids\": \"0403:cb48\""));
  CHECK(has(json,
            "\"opens\": true, \"problem\": \"\", \"mend\": \"\", \"config\": [\"[device]\", "
            "\"kind = \\\"delta\\\"\""));
  CHECK(has(json, "\"kinds\": [\"text-line\", \"other-line\"]"));
  CHECK(has(json,
            "{\"plugged\": false, \"kinds\": [\"arm\"], \"tried\": true, \"node\": \"HID\", "
            "\"ids\": \"1234:0006\"}\n]\n"));
}

}  // namespace haptic
