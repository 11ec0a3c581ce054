// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/desk/machine_facts.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <charconv>
#include <filesystem>
#include <fstream>
#include <limits>
#include <set>
#include <sstream>
#include <stdexcept>

namespace haptic {
namespace {

namespace fs = std::filesystem;

template <typename T>
std::optional<T> number_in(std::string_view text, int base = 10) {
  T value{};
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value, base);
  return result.ec == std::errc{} ? std::optional(value) : std::nullopt;
}

/// The rest of the line that begins so; empty: there is none.
std::string after(const std::string& path, const std::string& beginning) {
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with(beginning)) continue;
    const size_t at = line.find_first_not_of(" \t", beginning.size());
    return at == std::string::npos ? "" : line.substr(at);
  }
  return {};
}

void read_rights(const std::string& root, MachineFacts& facts) {
  const std::string self = root + "/proc/self/";
  facts.capabilities = number_in<uint64_t>(after(self + "status", "CapEff:"), 16).value_or(0);
  facts.realtime_priority = number_in<int64_t>(after(self + "limits", "Max realtime priority"));
  const std::string locked = after(self + "limits", "Max locked memory");
  facts.locked_memory = locked.starts_with("unlimited") ? std::numeric_limits<uint64_t>::max()
                                                        : number_in<uint64_t>(locked);
}

void read_kernel(const std::string& root, MachineFacts& facts) {
  const std::string kernel = root + "/proc/sys/kernel/";
  facts.kernel_release = first_line_of(kernel + "osrelease");
  facts.kernel_version = first_line_of(kernel + "version");
  facts.realtime_share_us = number_in<int64_t>(first_line_of(kernel + "sched_rt_runtime_us"));
  facts.realtime_period_us = number_in<int64_t>(first_line_of(kernel + "sched_rt_period_us"));
  const std::string system = root + "/sys/devices/system/";
  facts.clocksource = first_line_of(system + "clocksource/clocksource0/current_clocksource");
  facts.isolated = first_line_of(system + "cpu/isolated");
  facts.nohz_full = first_line_of(system + "cpu/nohz_full");
  if (facts.nohz_full.find("null") != std::string::npos) facts.nohz_full.clear();
  std::istringstream flags(after(root + "/proc/cpuinfo", "flags"));
  for (std::string flag; flags >> flag;) facts.virtual_machine |= flag == "hypervisor";

  std::set<std::string> governors;
  std::error_code error;
  for (const fs::directory_entry& core : fs::directory_iterator(system + "cpu", error)) {
    const std::string governor = first_line_of(core.path() / "cpufreq/scaling_governor");
    if (!governor.empty()) governors.insert(governor);
  }
  facts.governors.assign(governors.begin(), governors.end());
}

bool has_rules(const std::string& root) {
  for (const char* folder : {"/etc", "/run", "/usr/local/lib", "/usr/lib", "/lib"}) {
    std::error_code error;
    if (fs::exists(root + folder + "/udev/rules.d/70-hapticd.rules", error)) return true;
  }
  return false;
}

RuntimeFolder read_runtime(const std::string& path) {
  RuntimeFolder folder{.path = path};
  struct stat status {};
  folder.exists = lstat(path.c_str(), &status) == 0;
  if (folder.exists) {
    folder.is_folder = S_ISDIR(status.st_mode);
    folder.is_ours = status.st_uid == geteuid();
  }
  const std::string place = folder.exists ? path : fs::path(path).parent_path().string();
  folder.writable = faccessat(AT_FDCWD, place.c_str(), W_OK | X_OK, AT_EACCESS) == 0;
  return folder;
}

}  // namespace

MachineFacts read_machine(const std::string& root, const std::string& runtime) {
  MachineFacts facts;
  read_rights(root, facts);
  read_kernel(root, facts);
  facts.runtime = read_runtime(runtime);
  facts.rules_installed = has_rules(root);
  facts.spacenavd = processes_named(root, "spacenavd");
  facts.modem_manager = processes_named(root, "ModemManager");
  return facts;
}

void read_devices(MachineFacts& facts) {
  try {
    facts.devices = supported(kDevices, list_plugged());
  } catch (const std::runtime_error& error) {
    facts.udev_problem = error.what();
  }
  for (ListedDevice& device : facts.devices) device.access = read_access("", device.node);
}

}  // namespace haptic
