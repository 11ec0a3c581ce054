// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/desk/node_access.h"

#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>

#include "proto/os/message.h"
#include "proto/os/text.h"

namespace haptic {
namespace {

namespace fs = std::filesystem;

/// The processes below a folder like /proc.
std::vector<fs::path> processes(const std::string& root) {
  std::vector<fs::path> found;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(root + "/proc", error)) {
    const std::string name = entry.path().filename();
    if (std::ranges::all_of(name, [](char c) { return c >= '0' && c <= '9'; })) {
      found.push_back(entry.path());
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

Holder holder_at(const fs::path& process) {
  Holder holder;
  const std::string name = process.filename();
  std::from_chars(name.data(), name.data() + name.size(), holder.pid);
  holder.name = first_line_of(process / "comm");
  return holder;
}

bool has_open(const fs::path& process, const std::string& node) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(process / "fd", error)) {
    std::error_code gone;
    if (fs::read_symlink(entry.path(), gone) == node) return true;
  }
  return false;
}

/// True if a lock on that file is held: /proc/locks names each by "major:minor:inode".
bool is_locked(const std::string& root, const std::string& node) {
  struct stat status {};
  if (stat((root + node).c_str(), &status) != 0) return false;
  const std::string place =
      formatted(" %02x:%02x:%llu ", major(status.st_dev), minor(status.st_dev),
                static_cast<unsigned long long>(status.st_ino));
  std::ifstream locks(root + "/proc/locks");
  for (std::string line; std::getline(locks, line);) {
    if (line.find("FLOCK") != line.npos && line.find(place) != line.npos) return true;
  }
  return false;
}

/// The driver of the first interface of a USB device that has one.
std::string interface_driver(const std::string& root, const std::string& port) {
  std::error_code error;
  std::vector<fs::path> interfaces;
  const fs::path folder = root + "/sys/bus/usb/devices";
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().filename().string().starts_with(port + ":")) interfaces.push_back(entry);
  }
  std::sort(interfaces.begin(), interfaces.end());
  for (const fs::path& interface : interfaces) {
    std::error_code none;
    const fs::path driver = fs::read_symlink(interface / "driver", none);
    if (!driver.empty()) return driver.filename();
  }
  return {};
}

/// The driver of the kernel that reads the reports of a hidraw node.
std::string hid_driver(const std::string& root, const std::string& node) {
  const std::string name = fs::path(node).filename();
  std::error_code none;
  return fs::read_symlink(root + "/sys/class/hidraw/" + name + "/device/driver", none).filename();
}

std::string names_of(const std::vector<Holder>& holders) {
  return joined(holders, [](const Holder& holder) {
    return shown(holder.name) + " (pid " + std::to_string(holder.pid) + ")";
  });
}

bool is_ours(const Holder& holder) {
  return holder.name == "hapticd" || holder.name == "haptic-servo";
}

/// Another program drives the device.
Obstacle busy(const PluggedNode& node, const NodeAccess& access) {
  if (std::ranges::any_of(access.holders, is_ours)) {
    return {"a session of hapticd drives it", "`hapt stop` ends that session", true};
  }
  if (access.holders.empty()) {
    return {"another program drives it",
            "stop that program; as root `fuser " + node.path + "` names it", true};
  }
  return {"another program drives it: " + names_of(access.holders), "stop that program", true};
}

}  // namespace

std::string first_line_of(const std::string& path) {
  std::ifstream in(path);
  std::string line;
  std::getline(in, line);
  return line;
}

std::vector<Holder> processes_named(const std::string& root, const std::string& name) {
  std::vector<Holder> found;
  for (const fs::path& process : processes(root)) {
    Holder holder = holder_at(process);
    if (holder.name == name) found.push_back(std::move(holder));
  }
  return found;
}

NodeAccess read_access(const std::string& root, const PluggedNode& node) {
  NodeAccess seen;
  const std::string path = root + node.path;
  seen.exists = access(path.c_str(), F_OK) == 0;
  seen.allowed = access(path.c_str(), R_OK | W_OK) == 0;
  seen.locked = node.kind == NodeKind::kSerial && is_locked(root, node.path);
  seen.driver =
      node.kind == NodeKind::kHid ? hid_driver(root, node.path) : interface_driver(root, node.port);
  seen.power = first_line_of(root + "/sys/bus/usb/devices/" + node.port + "/power/control");
  for (const fs::path& process : processes(root)) {
    if (!has_open(process, node.path)) continue;
    Holder holder = holder_at(process);
    if (holder.pid != getpid()) seen.holders.push_back(std::move(holder));
  }
  return seen;
}

Obstacle obstacle_of(const PluggedNode& node, const NodeAccess& access) {
  if (!access.exists) {
    return {"its node is not there", "plug it in again; in a container, pass the node in", true};
  }
  if (!access.allowed) return {"this user may not open it", kMendRules, true};
  if (node.kind == NodeKind::kUsb) {
    // what the kernel itself has bound, the driver detaches
    if (access.driver == "usbfs") return busy(node, access);
    return {};
  }
  if (access.locked) return busy(node, access);
  if (access.holders.empty()) return {};
  if (node.kind == NodeKind::kSerial || std::ranges::any_of(access.holders, is_ours)) {
    return busy(node, access);
  }
  return {"read by " + names_of(access.holders) + " too, which may also command it",
          "stop that program while hapticd drives the device", false};
}

}  // namespace haptic
