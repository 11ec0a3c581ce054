// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/desk/report_facts.h"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <thread>

#include "proto/os/message.h"
#include "proto/os/text.h"

namespace haptic {
namespace {

std::string or_unknown(const std::string& text) {
  return text.empty() ? "unknown" : text;
}

std::string digits(const std::optional<int64_t>& value) {
  return value ? std::to_string(*value) : "unknown";
}

std::string megabytes(const std::optional<uint64_t>& bytes) {
  if (!bytes) return "unknown";
  const bool is_all = *bytes == std::numeric_limits<uint64_t>::max();
  return is_all ? "unlimited" : std::to_string(*bytes >> 20) + " MB";
}

const char* yes_or_no(bool is) {
  return is ? "yes" : "no";
}

/// The node as the kernel names it: a link that a person has made names more than the node.
std::string kernel_path(const std::string& node) {
  std::error_code error;
  const std::filesystem::path path = std::filesystem::canonical(node, error);
  return error ? node : path.string();
}

std::vector<std::string> device_facts(const MachineFacts& facts, const std::string& node) {
  const std::string path = kernel_path(node);
  const std::string known = path.starts_with("/dev/") ? shown(path) : "not below /dev";
  const auto device = std::ranges::find_if(
      facts.devices, [&](const ListedDevice& one) { return one.node.path == path; });
  if (device == facts.devices.end()) return {"node: " + known + ", of no USB device that is known"};
  const PluggedNode& plugged = device->node;
  const NodeAccess& access = device->access;
  return {"node: " + known + ", port " + shown(plugged.port) + ", kernel's driver " +
              or_unknown(shown(access.driver)) + ", power " + or_unknown(shown(access.power)),
          "device: " + usb_ids_of(plugged) + " " + shown(plugged.manufacturer) + " \"" +
              shown(plugged.name) + "\"" + (device->other_product ? ", another product" : ""),
          "may be: " + joined(device->rows, &DeviceRow::name)};
}

}  // namespace

std::vector<std::string> report_facts(const MachineFacts& facts, const std::string& node) {
  std::vector<std::string> lines = device_facts(facts, node);
  const auto add = [&](const char* what, const std::string& fact) {
    lines.push_back(what + (": " + fact));
  };
  if (!facts.udev_problem.empty()) add("udev", facts.udev_problem);
  add("kernel", or_unknown(facts.kernel_release) + ", " + or_unknown(facts.kernel_version));
  add("cores", std::to_string(std::thread::hardware_concurrency()) +
                   ", isolated: " + (facts.isolated.empty() ? "none" : facts.isolated) +
                   ", nohz_full: " + (facts.nohz_full.empty() ? "none" : facts.nohz_full) +
                   ", governors: " + or_unknown(joined(facts.governors)));
  add("virtual machine", yes_or_no(facts.virtual_machine));
  add("clock", or_unknown(facts.clocksource));
  add("real-time priority", digits(facts.realtime_priority));
  add("real-time share",
      digits(facts.realtime_share_us) + " of " + digits(facts.realtime_period_us) + " us");
  add("locked memory", megabytes(facts.locked_memory));
  add("capabilities", formatted("%llx", static_cast<unsigned long long>(facts.capabilities)));
  add("udev rules", facts.rules_installed ? "installed" : "not installed");
  add("ModemManager", facts.modem_manager.empty() ? "does not run" : "runs");
  add("spacenavd", facts.spacenavd.empty() ? "does not run" : "runs");
  return lines;
}

std::vector<std::string> report_facts(const std::string& node) {
  // the runtime folder is below a person's own, and no fact of a device
  MachineFacts facts = read_machine("", "");
  read_devices(facts);
  return report_facts(facts, node);
}

}  // namespace haptic
