// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "clients/desk/device_list.h"

namespace haptic {

/// The folder of sessions' sockets.
struct RuntimeFolder {
  std::string path;
  bool exists = false;  // it is made by the first session
  bool is_folder = true;
  bool is_ours = true;   // of this user
  bool writable = true;  // it, or the folder that it is to be made in
};

/// The facts about a machine that decide whether a session keeps its deadlines and reaches its
/// device. A file that is not there leaves its default: who runs in a container sees little.
struct MachineFacts {
  // of this process
  uint64_t capabilities = 0;                 // effective, one bit each
  std::optional<int64_t> realtime_priority;  // soft limit, 0 to 99
  std::optional<uint64_t> locked_memory;     // soft limit [bytes]; the largest number: unlimited
  RuntimeFolder runtime;
  // of the kernel
  std::string kernel_release, kernel_version;
  std::optional<int64_t> realtime_share_us, realtime_period_us;  // sched_rt_{runtime,period}_us
  std::string clocksource;
  std::vector<std::string> governors;  // each once, in the order of their names
  std::string isolated, nohz_full;     // lists of cores, as "2-3"
  bool virtual_machine = false;
  // of the devices
  bool rules_installed = false;
  std::vector<Holder> spacenavd, modem_manager;
  std::string udev_problem;  // why the devices are not known
  std::vector<ListedDevice> devices;
};

/// Reads everything but the devices below a root folder: "" is the machine, a test has its own.
/// `runtime` is the runtime folder.
MachineFacts read_machine(const std::string& root, const std::string& runtime);

/// Reads the devices of this machine, or why they are not known.
void read_devices(MachineFacts& facts);

}  // namespace haptic
