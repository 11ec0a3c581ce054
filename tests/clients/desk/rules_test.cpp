// SPDX-License-Identifier: GPL-3.0-or-later
// packaging/70-hapticd.rules names every device of proto/config/devices.def.
#include <catch2/catch.hpp>
#include <fstream>
#include <regex>
#include <sstream>

#include "proto/config/devices.h"
#include "tests/support/data.h"

namespace haptic {
namespace {

/// True if the rules have a line for these ids that holds both texts.
bool has_rule(const std::vector<std::string>& rules, const std::string& vendor,
              const std::string& product, const std::string& subsystem, const std::string& effect) {
  const std::regex of_vendor("\\{idVendor\\}==\"[^\"]*" + vendor + "[^\"]*\"");
  const std::regex of_product("\\{idProduct\\}==\"[^\"]*" + product + "[^\"]*\"");
  for (const std::string& rule : rules) {
    if (rule.find("SUBSYSTEM==\"" + subsystem + "\"") != std::string::npos &&
        rule.find(effect) != std::string::npos && std::regex_search(rule, of_vendor) &&
        (rule.find("{idProduct}") == std::string::npos || std::regex_search(rule, of_product))) {
      return true;
    }
  }
  return false;
}

std::vector<std::string> rules() {
  std::ifstream in(test::from_source("packaging/70-hapticd.rules"));
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

void check_ids(const std::vector<std::string>& lines, const DeviceRow& row,
               const std::string& ids) {
  INFO(row.name << " " << ids);
  REQUIRE(ids.size() == 9);
  const std::string vendor = ids.substr(0, 4), product = ids.substr(5);
  const char* subsystem = row.node == NodeKind::kHid      ? "hidraw"
                          : row.node == NodeKind::kSerial ? "tty"
                                                          : "usb";
  CHECK(has_rule(lines, vendor, product, subsystem, "TAG+=\"uaccess\""));
  CHECK(has_rule(lines, vendor, product, "usb", "GOTO=\"hapticd_power\""));
  if (row.node == NodeKind::kSerial) {
    CHECK(has_rule(lines, vendor, product, "tty", "ID_MM_DEVICE_IGNORE"));
  }
}

}  // namespace

TEST_CASE("udev rules: every device of the table may be opened and is not suspended") {
  const std::vector<std::string> lines = rules();
  REQUIRE(lines.size() > 5);
  for (const DeviceRow& row : kDevices) {
    std::istringstream all{std::string(row.usb_ids)};
    for (std::string ids; all >> ids;) check_ids(lines, row, ids);
  }
  // devices whose rows the table may not have yet
  check_ids(lines, {.name = "Falcon", .id = {}, .node = NodeKind::kUsb}, "0403:cb48");
  check_ids(lines, {.name = "SpaceNavigator", .id = {}, .node = NodeKind::kHid}, "046d:c626");
  check_ids(lines, {.name = "Teensy", .id = {}, .node = NodeKind::kSerial}, "16c0:0483");
  CHECK_FALSE(has_rule(lines, "dead", "beef", "usb", "uaccess"));
}

TEST_CASE("udev rules: each jump has its label") {
  std::string all;
  for (const std::string& line : rules()) all += line + "\n";
  const std::regex jump("GOTO=\"([a-z_]+)\"");
  for (std::sregex_iterator at(all.begin(), all.end(), jump), end; at != end; ++at) {
    CHECK(all.find("\nLABEL=\"" + (*at)[1].str() + "\"\n") != std::string::npos);
  }
}

}  // namespace haptic
