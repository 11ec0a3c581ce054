// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/plugged/find_node.h"

#include <fcntl.h>
#include <libudev.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>

#include "proto/os/message.h"
#include "proto/os/serial_port.h"

namespace haptic {
namespace {

struct Unref {
  void operator()(udev* u) const { udev_unref(u); }
  void operator()(udev_enumerate* e) const { udev_enumerate_unref(e); }
  void operator()(udev_device* d) const { udev_device_unref(d); }
};
template <typename T>
using Held = std::unique_ptr<T, Unref>;

struct Subsystem {
  const char* name;
  NodeKind kind;
};
constexpr Subsystem kSubsystems[] = {
    {"tty", NodeKind::kSerial}, {"hidraw", NodeKind::kHid}, {"usb", NodeKind::kUsb}};

std::string attribute(udev_device* device, const char* name) {
  const char* value = udev_device_get_sysattr_value(device, name);
  return value != nullptr ? value : "";
}

uint16_t id_of(udev_device* device, const char* name) {
  const std::string text = attribute(device, name);
  uint16_t id = 0;
  std::from_chars(text.data(), text.data() + text.size(), id, 16);
  return id;
}

/// The USB device to which a node belongs: itself or one above it; none: not on USB.
udev_device* usb_device_of(udev_device* device, NodeKind kind) {
  if (kind != NodeKind::kUsb) {
    return udev_device_get_parent_with_subsystem_devtype(device, "usb", "usb_device");
  }
  const char* type = udev_device_get_devtype(device);
  return type != nullptr && std::strcmp(type, "usb_device") == 0 ? device : nullptr;
}

/// The first of a node's other names, which udev makes of what the device says of itself.
std::string link_of(udev_device* device) {
  const char* name = udev_list_entry_get_name(udev_device_get_devlinks_list_entry(device));
  return name != nullptr ? name : "";
}

void list(udev* context, const Subsystem& subsystem, std::vector<PluggedNode>& nodes) {
  const Held<udev_enumerate> all(udev_enumerate_new(context));
  if (!all || udev_enumerate_add_match_subsystem(all.get(), subsystem.name) < 0 ||
      udev_enumerate_scan_devices(all.get()) < 0) {
    throw std::runtime_error("udev does not list the devices; is /sys mounted?");
  }
  udev_list_entry* entry = nullptr;
  udev_list_entry_foreach(entry, udev_enumerate_get_list_entry(all.get())) {
    const Held<udev_device> device(
        udev_device_new_from_syspath(context, udev_list_entry_get_name(entry)));
    if (!device) continue;  // unplugged since
    const char* path = udev_device_get_devnode(device.get());
    udev_device* usb = usb_device_of(device.get(), subsystem.kind);
    if (path == nullptr || usb == nullptr) continue;
    nodes.push_back({subsystem.kind, path, id_of(usb, "idVendor"), id_of(usb, "idProduct"),
                     attribute(usb, "serial"), udev_device_get_sysname(usb),
                     attribute(usb, "manufacturer"), attribute(usb, "product"),
                     link_of(device.get())});
  }
}

std::string id_text(const PluggedNode& node) {
  char text[16];
  std::snprintf(text, sizeof text, "%04x:%04x", unsigned{node.vendor}, unsigned{node.product});
  return text;
}

bool has_id(std::string_view ids, const PluggedNode& node) {
  return ids.find(id_text(node)) != std::string_view::npos;
}

/// Naming a serial number or a port vouches for a device whose product calls itself otherwise.
bool is_vouched_for(const DeviceRow& row, const PluggedConfig& wanted, const PluggedNode& node) {
  const bool named = !view(wanted.serial).empty() || !view(wanted.port).empty();
  return named && row.node == node.kind && has_id(row.usb_ids, node);
}

bool is_chosen(const PluggedConfig& wanted, const PluggedNode& node) {
  const std::string_view serial = view(wanted.serial), port = view(wanted.port);
  return (serial.empty() || node.serial == serial) && (port.empty() || node.port == port);
}

std::string one_of(const std::vector<PluggedNode>& nodes) {
  return joined(nodes, [](const PluggedNode& node) {
    return node.path + " (port " + node.port +
           (node.serial.empty() ? "" : ", serial " + shown(node.serial)) + ")";
  });
}

/// Opens a node that needs no setting up.
FileDescriptor open_plain(const std::string& path) {
  FileDescriptor fd(open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
  if (fd.is_open()) return fd;
  const int error = errno;
  const bool right = error != EACCES && error != EPERM;
  throw InputError(
      path + ": cannot be opened: " + std::strerror(error) + "; " +
      (right ? "plug the device in again"
             : "install hapticd's udev rules (`hapt doctor` says how), plug it in again"));
}

}  // namespace

std::vector<PluggedNode> list_plugged() {
  // without it udev lists nothing, and says nothing
  if (access("/sys/bus", F_OK) != 0) {
    throw std::runtime_error("there is no /sys/bus here, so no device is found; mount /sys");
  }
  const Held<udev> context(udev_new());
  if (!context) throw std::runtime_error("udev does not answer; is /sys mounted?");
  std::vector<PluggedNode> nodes;
  for (const Subsystem& subsystem : kSubsystems) list(context.get(), subsystem, nodes);
  std::sort(nodes.begin(), nodes.end(),
            [](const PluggedNode& a, const PluggedNode& b) { return a.path < b.path; });
  return nodes;
}

bool is_of(const DeviceRow& row, const PluggedNode& node) {
  return row.node == node.kind && has_id(row.usb_ids, node) &&
         node.name.find(row.usb_product) != std::string::npos;
}

std::string find_node(const DeviceConfig& device) {
  return find_node(row_of(device.kind), device);
}

std::string find_node(const DeviceRow& row, const DeviceConfig& device) {
  if (row.node == NodeKind::kNone) return {};
  if (row.node == NodeKind::kSerial) return std::string(view(device.serial.path));
  std::vector<PluggedNode> found;
  bool any = false;
  std::string refused;
  for (const PluggedNode& node : list_plugged()) {
    if (row.node == node.kind && has_id(row.usb_refused, node)) {
      refused = "; " + node.path + " (" + id_text(node) + ", " + shown(node.name) + ") is none";
    }
    if (!is_of(row, node) && !is_vouched_for(row, device.plugged, node)) continue;
    any = true;
    if (is_chosen(device.plugged, node)) found.push_back(node);
  }
  const std::string name(row.name);
  if (found.empty()) {
    throw InputError("no " + name + " is plugged in" +
                     (any ? " with that 'serial' and 'port'; correct [device.usb]"
                          : "; plug it in and switch it on") +
                     " (`hapt devices` lists what is there)" + refused);
  }
  if (found.size() > 1) {
    throw InputError("several devices may be the " + name + ": " + one_of(found) +
                     "; say which with 'serial' or 'port' in [device.usb]");
  }
  return found.front().path;
}

FileDescriptor open_node(NodeKind kind, const std::string& path) {
  if (kind == NodeKind::kNone) return {};
  return kind == NodeKind::kSerial ? open_serial_port(path) : open_plain(path);
}

FileDescriptor open_node(const DeviceConfig& device) {
  return open_node(row_of(device.kind).node, find_node(device));
}

}  // namespace haptic
