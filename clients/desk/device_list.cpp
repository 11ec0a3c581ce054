// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/desk/device_list.h"

#include <algorithm>
#include <array>
#include <ostream>

#include "proto/os/json.h"
#include "proto/os/message.h"
#include "proto/os/text.h"

namespace haptic {
namespace {

constexpr size_t kNameWidth = 19;  // characters of the first column
const std::string kIndent(kNameWidth + 2, ' ');

bool has_ids(const DeviceRow& row, const PluggedNode& node) {
  DeviceRow of_any_name = row;
  of_any_name.usb_product = {};
  return is_of(of_any_name, node);
}

bool is_any_serial(const DeviceRow& row, const PluggedNode& node) {
  return node.kind == NodeKind::kSerial && row.node == NodeKind::kSerial && row.usb_ids.empty();
}

const char* state_of(const DeviceRow& row) {
  if (!row.has_node()) return "no hardware needed";
  return row.tried ? "tried on hardware" : "emulated only, not yet tried on hardware";
}

const char* word_of(NodeKind kind) {
  constexpr std::array kWords{"none", "serial", "HID", "USB"};  // by NodeKind
  return kWords[static_cast<size_t>(kind)];
}

/// True if one of the plugged devices is, or may be, that row's.
bool is_among(const DeviceRow& row, const std::vector<ListedDevice>& plugged) {
  return std::ranges::any_of(plugged, [&](const ListedDevice& device) {
    return !device.other_product &&
           std::ranges::any_of(device.rows, [&](const DeviceRow& one) { return one.id == row.id; });
  });
}

/// A text in the quotes of TOML, which are those of JSON; texts of a device may hold anything.
std::string toml(const std::string& text) {
  return json_line(text);
}

std::string identity(const PluggedNode& node) {
  std::string text = usb_ids_of(node);
  if (!node.manufacturer.empty()) text += " " + shown(node.manufacturer);
  if (!node.name.empty()) text += " \"" + shown(node.name) + "\"";
  text += node.serial.empty() ? ", no serial number" : ", serial number " + shown(node.serial);
  return text + ", port " + shown(node.port) + ", " + shown(node.path);
}

void print_one(const ListedDevice& device, std::ostream& out) {
  const bool known = device.rows.size() == 1 && !device.other_product;
  const std::string name = known                  ? std::string(device.rows.front().name)
                           : device.other_product ? "another product"
                                                  : "serial port";
  out << "  " << padded(name, kNameWidth) << identity(device.node) << '\n';
  if (device.other_product) {
    const DeviceRow& row = device.rows.front();
    out << kIndent << "has the ids of " << row.name << ", whose product's name holds \""
        << row.usb_product << "\": not driven\n";
    return;
  }
  if (known) {
    out << kIndent << state_of(device.rows.front()) << '\n';
  } else {
    out << kIndent << "may be any of: " << joined(device.rows, &DeviceRow::name)
        << " (the config says which)\n";
  }
  const Obstacle obstacle = obstacle_of(device.node, device.access);
  out << kIndent << (obstacle.blocks ? "cannot be opened" : "can be opened");
  if (!obstacle.problem.empty()) out << ": " << obstacle.problem << "; " << obstacle.mend;
  out << '\n';
  bool first = true;
  for (const std::string& line : config_lines(device)) {
    out << kIndent << (first ? "config:  " : "         ") << one_line(line) << '\n';
    first = false;
  }
}

Json json_of(const ListedDevice& device) {
  Json kinds = Json::array();
  if (!device.other_product) {
    for (const DeviceRow& row : device.rows) kinds.push_back(row.name);
  }
  const PluggedNode& node = device.node;
  const Obstacle obstacle = obstacle_of(node, device.access);
  const bool known = kinds.size() == 1;
  return {{"plugged", true},
          {"kinds", kinds},
          {"tried", known && device.rows.front().tried},
          {"node", word_of(node.kind)},
          {"path", node.path},
          {"ids", usb_ids_of(node)},
          {"manufacturer", node.manufacturer},
          {"product", node.name},
          {"serial", node.serial},
          {"port", node.port},
          {"opens", !obstacle.blocks},
          {"problem", obstacle.problem},
          {"mend", obstacle.mend},
          {"config", config_lines(device)}};
}

Json json_of(const DeviceRow& row) {
  return {{"plugged", false},
          {"kinds", Json::array({row.name})},
          {"tried", row.tried},
          {"node", word_of(row.node)},
          {"ids", row.usb_ids}};
}

}  // namespace

std::string usb_ids_of(const PluggedNode& node) {
  return formatted("%04x:%04x", unsigned{node.vendor}, unsigned{node.product});
}

std::vector<ListedDevice> supported(std::span<const DeviceRow> rows,
                                    const std::vector<PluggedNode>& nodes) {
  std::vector<ListedDevice> devices;
  for (const PluggedNode& node : nodes) {
    ListedDevice device{.node = node};
    const auto add_where = [&](auto&& holds) {
      std::ranges::copy_if(rows, std::back_inserter(device.rows), holds);
    };
    add_where([&](const DeviceRow& row) { return is_of(row, node); });
    if (device.rows.empty()) {
      add_where([&](const DeviceRow& row) { return has_ids(row, node); });
      device.other_product = !device.rows.empty();
    }
    if (device.rows.empty()) {
      add_where([&](const DeviceRow& row) { return is_any_serial(row, node); });
    }
    if (!device.rows.empty()) devices.push_back(std::move(device));
  }
  return devices;
}

bool is_certain(const ListedDevice& device) {
  return !device.other_product && !device.rows.front().usb_ids.empty();
}

std::vector<std::string> config_lines(const ListedDevice& device) {
  if (device.other_product) return {};
  const PluggedNode& node = device.node;
  std::string kind = "kind = \"" + std::string(device.rows.front().name) + "\"";
  for (size_t i = 1; i < device.rows.size(); ++i) {
    kind += std::string(i == 1 ? "  # or " : ", ") + std::string(device.rows[i].name);
  }
  if (node.kind == NodeKind::kSerial) {
    return {"[device]", kind, "[device.serial]",
            "path = " + toml(node.link.empty() ? node.path : node.link)};
  }
  return {"[device]", kind, "[device.usb]  # only where several are plugged in",
          node.serial.empty() ? "port = " + toml(node.port) : "serial = " + toml(node.serial)};
}

void print_devices(std::span<const DeviceRow> rows, const std::vector<ListedDevice>& plugged,
                   std::ostream& out) {
  out << "plugged in:" << (plugged.empty() ? " no device that hapticd drives\n" : "\n");
  for (const ListedDevice& device : plugged) print_one(device, out);
  out << "\nsupported besides:\n";
  for (const DeviceRow& row : rows) {
    if (is_among(row, plugged)) continue;
    out << "  " << padded(std::string(row.name), kNameWidth) << state_of(row);
    if (row.has_node()) {
      out << "; " << word_of(row.node) << (row.usb_ids.empty() ? "" : " ") << row.usb_ids;
    }
    out << '\n';
  }
}

void print_devices_json(std::span<const DeviceRow> rows, const std::vector<ListedDevice>& plugged,
                        std::ostream& out) {
  Json all = Json::array();
  for (const ListedDevice& device : plugged) all.push_back(json_of(device));
  for (const DeviceRow& row : rows) {
    if (!is_among(row, plugged)) all.push_back(json_of(row));
  }
  out << json_lines(all);
}

}  // namespace haptic
