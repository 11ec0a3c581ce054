// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "proto/config/devices.h"
#include "proto/os/file_descriptor.h"

namespace haptic {

/// A node of a USB device that is plugged in, by udev. Its texts come from the device: escape them
/// before they are printed.
struct PluggedNode {
  NodeKind kind = NodeKind::kNone;
  std::string path;  // "/dev/hidraw0"
  uint16_t vendor = 0, product = 0;
  std::string serial;              // serial number; empty: it has none
  std::string port;                // "1-2.3"
  std::string manufacturer, name;  // of the product
  std::string link{};              // "/dev/serial/by-id/…": stays when it is plugged in again
};

/// All serial, hidraw and USB nodes of USB devices, in the order of their paths. One device may
/// have several nodes. Throws std::runtime_error if udev does not answer.
std::vector<PluggedNode> list_plugged();

/// True if a row of devices.def may be this node, by its kind, its ids and the product's name.
bool is_of(const DeviceRow& row, const PluggedNode& node);

/// The node of the configured device: the path of [device.serial], or that of the one plugged in
/// that its row and [device.usb] describe; empty: it has none. Throws InputError in one line if
/// none or several are plugged in.
std::string find_node(const DeviceConfig& device);
/// As above, by the row that is given.
std::string find_node(const DeviceRow& row, const DeviceConfig& device);

/// Opens a node so that it can be driven, or be let go of. Throws InputError in one line: what,
/// why, how to mend it.
FileDescriptor open_node(NodeKind kind, const std::string& path);

/// Opens that of the configured device; not open: it has none.
FileDescriptor open_node(const DeviceConfig& device);

}  // namespace haptic
