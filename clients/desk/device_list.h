// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <iosfwd>
#include <span>
#include <string>
#include <vector>

#include "clients/desk/node_access.h"

namespace haptic {

/// A node that is plugged in and that hapticd may drive.
struct ListedDevice {
  PluggedNode node{};
  NodeAccess access{};
  std::vector<DeviceRow> rows{};  // that it may be; several: any of these firmwares is behind it
  bool other_product = false;     // the ids are a row's, the name of the product is not
};

/// Lists the nodes that are, or may be, a row's. A row on a serial node that names no ids may be
/// behind any serial port.
std::vector<ListedDevice> supported(std::span<const DeviceRow> rows,
                                    const std::vector<PluggedNode>& nodes);

/// "vvvv:pppp".
std::string usb_ids_of(const PluggedNode& node);

/// True if it is one row's for certain: by its ids.
bool is_certain(const ListedDevice& device);

/// The lines of a session file that choose this device, also among several; none for another
/// product.
std::vector<std::string> config_lines(const ListedDevice& device);

/// For people: what is plugged in, then what is supported besides.
void print_devices(std::span<const DeviceRow> rows, const std::vector<ListedDevice>& plugged,
                   std::ostream& out);
/// One array, an object for each device that is plugged in, then one for each row that is not.
void print_devices_json(std::span<const DeviceRow> rows, const std::vector<ListedDevice>& plugged,
                        std::ostream& out);

}  // namespace haptic
