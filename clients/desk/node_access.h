// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "device-io/plugged/find_node.h"

namespace haptic {

/// A process that has a node open.
struct Holder {
  int pid = 0;
  std::string name;  // as the kernel keeps it
};

/// The facts that decide whether this process can open a node.
struct NodeAccess {
  bool exists = false;
  bool allowed = false;           // to read and write
  bool locked = false;            // another program drives this serial node
  std::string driver{};           // of the HID device, else of the interface; usbfs: a program
  std::string power{};            // power/control of its USB device: "on", or "auto" suspends it
  std::vector<Holder> holders{};  // of other users' processes only root learns
};

/// Reads that below a root folder ("/"; a test has its own) without opening the node: opening a
/// serial one would reset some boards. A file that is not there leaves its default.
NodeAccess read_access(const std::string& root, const PluggedNode& node);

/// The first line of a file; empty where there is none.
std::string first_line_of(const std::string& path);

/// All processes below root/proc with that name.
std::vector<Holder> processes_named(const std::string& root, const std::string& name);

/// Why a node cannot be opened, or what may disturb it.
struct Obstacle {
  std::string problem, mend;  // of people's words; empty: nothing is in the way
  bool blocks = false;        // it cannot be opened
};
Obstacle obstacle_of(const PluggedNode& node, const NodeAccess& access);

/// How to install the udev rules.
inline constexpr const char* kMendRules =
    "install hapticd's package, or as root: cp packaging/70-hapticd.rules /etc/udev/rules.d/ && "
    "udevadm control --reload && udevadm trigger; then plug the device in again";

}  // namespace haptic
