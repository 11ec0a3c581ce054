// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for clients/desk/findings.cpp and report_facts.cpp on machines of the test's own.
#include "clients/desk/findings.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <sstream>

#include "clients/desk/report_facts.h"
#include "tests/support/hostile_text.h"

namespace haptic {
namespace {

constexpr DeviceRow kDeltaRow{
    .name = "delta", .id = DeviceKind{}, .node = NodeKind::kUsb, .usb_ids = "0403:cb48"};
constexpr DeviceRow kLineRow{.name = "line", .id = DeviceKind{}, .node = NodeKind::kSerial};

ListedDevice plugged(const DeviceRow& row, const std::string& path) {
  ListedDevice device{.rows = {row}};
  device.node.kind = row.node;
  device.node.path = path;
  device.node.port = "1-2";
  device.access = {.exists = true, .allowed = true, .power = "on"};
  return device;
}

/// A desk where nothing is left to do.
MachineFacts best() {
  MachineFacts facts;
  facts.realtime_priority = 95;
  facts.locked_memory = std::numeric_limits<uint64_t>::max();
  facts.runtime = {.path = "/run/user/1000/hapticd"};
  facts.kernel_release = "6.1.0-21-rt-amd64";
  facts.kernel_version = "#1 SMP PREEMPT_RT Debian";
  facts.realtime_share_us = 950'000;
  facts.realtime_period_us = 1'000'000;
  facts.clocksource = "tsc";
  facts.governors = {"performance"};
  facts.isolated = facts.nohz_full = "3";
  facts.rules_installed = true;
  facts.devices = {plugged(kDeltaRow, "/dev/bus/usb/001/004")};
  return facts;
}

/// The findings that are not good.
std::vector<Finding> bad(const MachineFacts& facts) {
  std::vector<Finding> findings = findings_of(facts);
  std::erase_if(findings, [](const Finding& one) { return one.grade == Grade::kGood; });
  return findings;
}

/// The only finding that is not good; it has a mend.
Finding only(const MachineFacts& facts) {
  const std::vector<Finding> findings = bad(facts);
  REQUIRE(findings.size() == 1);
  CHECK_FALSE(findings[0].mend.empty());
  CHECK(is_any_wrong(findings) == (findings[0].grade == Grade::kWrong));
  return findings[0];
}

/// Subject and grade of what a change makes of the best desk.
template <typename Change>
std::pair<std::string, Grade> after(Change change) {
  MachineFacts facts = best();
  change(facts);
  const Finding finding = only(facts);
  return {finding.subject, finding.grade};
}

using Seen = std::pair<std::string, Grade>;

}  // namespace

TEST_CASE("findings: of the best desk all are good and none has a mend") {
  CHECK(bad(best()).empty());
  for (const Finding& one : findings_of(best())) {
    INFO(one.subject);
    CHECK(one.mend.empty());
    CHECK_FALSE(one.fact.empty());
  }
}

TEST_CASE("findings: rights that lack, by limit or by capability") {
  CHECK(after([](MachineFacts& m) { m.realtime_priority = 89; }) ==
        Seen("real-time priority", Grade::kWrong));
  CHECK(after([](MachineFacts& m) { m.locked_memory = 8 << 20; }) ==
        Seen("locked memory", Grade::kWrong));
  MachineFacts root = best();
  root.realtime_priority = 0;
  root.locked_memory = 8 << 20;
  root.capabilities = uint64_t{1} << 23 | uint64_t{1} << 14;
  CHECK(bad(root).empty());
  root.capabilities = uint64_t{1} << 23;
  CHECK(only(root).subject == "locked memory");
  CHECK(only(root).fact.find("8192 KiB") != std::string::npos);
}

TEST_CASE("findings: what the kernel is and does") {
  CHECK(after([](MachineFacts& m) { m.kernel_version = "#1 SMP PREEMPT_DYNAMIC"; }) ==
        Seen("kernel", Grade::kHint));
  CHECK(after([](MachineFacts& m) { m.virtual_machine = true; }) == Seen("kernel", Grade::kHint));
  CHECK(after([](MachineFacts& m) { m.realtime_share_us = 500'000; }) ==
        Seen("real-time throttling", Grade::kWrong));
  CHECK(after([](MachineFacts& m) { m.clocksource = "hpet"; }) == Seen("clock", Grade::kWrong));
  CHECK(after([](MachineFacts& m) {
          m.governors = {"performance", "powersave"};
        }) == Seen("CPU governor", Grade::kHint));
  CHECK(after([](MachineFacts& m) { m.isolated = m.nohz_full = ""; }) ==
        Seen("isolated cores", Grade::kHint));
  MachineFacts unthrottled = best();
  unthrottled.realtime_share_us = -1;
  unthrottled.clocksource = "kvm-clock";
  unthrottled.governors.clear();
  CHECK(bad(unthrottled).empty());
}

TEST_CASE("findings: a runtime folder that cannot be used") {
  const Seen wrong("runtime folder", Grade::kWrong);
  CHECK(after([](MachineFacts& m) { m.runtime.writable = false; }) == wrong);
  CHECK(after([](MachineFacts& m) {
          m.runtime.exists = true;
          m.runtime.is_ours = false;
        }) == wrong);
  CHECK(after([](MachineFacts& m) {
          m.runtime.exists = true;
          m.runtime.is_folder = false;
        }) == wrong);
}

TEST_CASE("findings: rules are wrong to lack where a device is plugged in, else a hint") {
  CHECK(after([](MachineFacts& m) { m.rules_installed = false; }) ==
        Seen("udev rules", Grade::kWrong));
  MachineFacts none = best();
  none.devices.clear();
  CHECK(only(none).subject == "devices");
  CHECK(only(none).grade == Grade::kHint);
  none.rules_installed = false;
  CHECK_FALSE(is_any_wrong(findings_of(none)));
  none.udev_problem = "udev does not answer";
  CHECK(is_any_wrong(findings_of(none)));
}

TEST_CASE("findings: of a device its rights, its power, and who else talks to it") {
  const Seen wrong("delta at /dev/bus/usb/001/004", Grade::kWrong);
  CHECK(after([](MachineFacts& m) { m.devices[0].access.allowed = false; }) == wrong);
  CHECK(after([](MachineFacts& m) { m.devices[0].access.driver = "usbfs"; }) == wrong);
  CHECK(after([](MachineFacts& m) { m.devices[0].access.power = "auto"; }) == wrong);
  CHECK(after([](MachineFacts& m) {
          m.spacenavd = {{812, "spacenavd"}};
        }) == Seen("spacenavd", Grade::kHint));
  MachineFacts knob = best();
  knob.devices[0].access.driver = "logitech";
  CHECK(bad(knob).empty());
  CHECK(findings_of(knob).back().fact.find("hid-logitech") != std::string::npos);
  MachineFacts modem = best();
  modem.modem_manager = {{9, "ModemManager"}};
  modem.devices = {plugged(kLineRow, "/dev/ttyACM0")};
  CHECK(bad(modem).empty());
  modem.rules_installed = false;
  CHECK(bad(modem).size() == 2);
  // the port may be anybody's
  CHECK_FALSE(is_any_wrong(findings_of(modem)));
}

TEST_CASE("findings: printed one a line, the mend below, in JSON as they are") {
  MachineFacts facts = best();
  facts.clocksource = "hpet";
  std::ostringstream text, json;
  print_findings(findings_of(facts), text);
  print_findings_json(findings_of(facts), json);
  INFO(text.str());
  CHECK(text.str().find("\nWRONG  clock: hpet: slow to read, each tick reads it several times\n"
                        "       mend: as root: echo tsc > ") != std::string::npos);
  CHECK(text.str().ends_with("\n\n1 thing is wrong\n"));
  CHECK(json.str().find("{\"grade\": \"wrong\", \"subject\": \"clock\", \"fact\": \"hpet: slow") !=
        std::string::npos);

  for (const std::string& hostile : test::kHostileTexts) {
    facts.clocksource = facts.kernel_release = hostile;
    facts.governors = {hostile};
    std::ostringstream out;
    print_findings(findings_of(facts), out);
    CHECK(out.str().find('\x1b') == std::string::npos);
  }
}

TEST_CASE("report facts: the device by its ids, and the machine, without a name of anybody") {
  MachineFacts facts = best();
  facts.runtime.path = "/home/anna/run";
  facts.modem_manager = {{17, "ModemManager"}};
  PluggedNode& node = facts.devices[0].node;
  node.vendor = 0x0403, node.product = 0xcb48;
  node.manufacturer = "Novint", node.name = "Falcon", node.serial = "F001";
  node.link = "/dev/serial/by-id/F001";
  const std::string text =
      joined(report_facts(facts, node.path), [](const std::string& line) { return line + "\n"; });
  for (const char* part :
       {"node: /dev/bus/usb/001/004, port 1-2, kernel's driver unknown, power on",
        "device: 0403:cb48 Novint \"Falcon\"", "may be: delta",
        "kernel: 6.1.0-21-rt-amd64, #1 SMP PREEMPT_RT Debian", "governors: performance",
        "locked memory: unlimited", "real-time share: 950000 of 1000000 us", "ModemManager: runs",
        "spacenavd: does not run"}) {
    CAPTURE(part, text);
    CHECK(text.find(part) != std::string::npos);
  }
  for (const char* part : {"anna", "F001", "/home", "\x1b"}) {
    CAPTURE(part, text);
    CHECK(text.find(part) == std::string::npos);
  }
  // a link of the user's own to a program's terminal
  const std::vector<std::string> other = report_facts(MachineFacts{}, "/home/anna/own");
  CHECK(other.front() == "node: not below /dev, of no USB device that is known");
}

}  // namespace haptic
