// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/desk/findings.h"

#include <algorithm>
#include <array>
#include <limits>
#include <ostream>

#include "proto/os/json.h"
#include "proto/os/message.h"
#include "proto/os/priorities.h"
#include "proto/os/text.h"

namespace haptic {
namespace {

// capability numbers, linux/capability.h
constexpr int kIpcLock = 14, kSysNice = 23;

constexpr const char* kUnknown = "unknown: /proc does not say";
constexpr const char* kMendLimits =
    "as root: printf 'NAME - rtprio 95\nNAME - memlock unlimited\n' > "
    "/etc/security/limits.d/90-hapticd.conf, NAME being the user's; log in again";

bool may(const MachineFacts& facts, int capability) {
  return (facts.capabilities >> capability & 1) != 0;
}

Finding priority_of(const MachineFacts& facts) {
  constexpr const char* kSubject = "real-time priority";
  if (may(facts, kSysNice)) return {Grade::kGood, kSubject, "granted (CAP_SYS_NICE)"};
  if (!facts.realtime_priority) return {Grade::kHint, kSubject, kUnknown};
  const std::string most = std::to_string(*facts.realtime_priority);
  if (*facts.realtime_priority >= kGuardPriority) {
    return {Grade::kGood, kSubject, "granted up to " + most};
  }
  return {Grade::kWrong, kSubject,
          "at most " + most + ", hapticd wants " + std::to_string(kGuardPriority) +
              ": other programs make the force late",
          kMendLimits};
}

Finding memory_of(const MachineFacts& facts) {
  constexpr const char* kSubject = "locked memory";
  if (may(facts, kIpcLock)) return {Grade::kGood, kSubject, "granted (CAP_IPC_LOCK)"};
  if (!facts.locked_memory) return {Grade::kHint, kSubject, kUnknown};
  if (*facts.locked_memory == std::numeric_limits<uint64_t>::max()) {
    return {Grade::kGood, kSubject, "granted, unlimited"};
  }
  return {Grade::kWrong, kSubject,
          "at most " + std::to_string(*facts.locked_memory / 1024) +
              " KiB: memory may be swapped out under the force loop",
          kMendLimits};
}

Finding kernel_of(const MachineFacts& facts) {
  const bool realtime = facts.kernel_version.find("PREEMPT_RT") != std::string::npos;
  const std::string fact =
      shown(facts.kernel_release) +
      (realtime ? ", PREEMPT_RT" : ", not PREEMPT_RT: single ticks may be late") +
      (facts.virtual_machine ? "; a virtual machine, which its host may stop" : "");
  if (realtime && !facts.virtual_machine) return {Grade::kGood, "kernel", fact};
  return {Grade::kHint, "kernel", fact,
          realtime ? "use a device on the machine itself"
                   : "apt install linux-image-rt-amd64 (or -arm64) and start it"};
}

Finding throttling_of(const MachineFacts& facts) {
  constexpr const char* kSubject = "real-time throttling";
  constexpr double kEnough = 0.9;  // share of a core; a servo that spins before its tick needs less
  if (!facts.realtime_share_us || !facts.realtime_period_us || *facts.realtime_period_us <= 0) {
    return {Grade::kGood, kSubject, "this kernel has none"};
  }
  const int64_t share_us = *facts.realtime_share_us, period_us = *facts.realtime_period_us;
  if (share_us < 0) return {Grade::kGood, kSubject, "off"};
  const std::string fact =
      std::to_string(share_us) + " of every " + std::to_string(period_us) + " µs are real time's";
  if (static_cast<double>(share_us) / static_cast<double>(period_us) >= kEnough) {
    return {Grade::kGood, kSubject, fact};
  }
  return {Grade::kWrong, kSubject, fact + ": the force stops for the rest",
          "as root: sysctl kernel.sched_rt_runtime_us=" + std::to_string(period_us / 20 * 19)};
}

Finding clock_of(const MachineFacts& facts) {
  // read without a system call, in tens of nanoseconds
  constexpr std::array kFast{"tsc", "arch_sys_counter", "kvm-clock", "hyperv_clocksource_tsc_page"};
  const std::string fact = shown(facts.clocksource);
  if (facts.clocksource.empty()) return {Grade::kHint, "clock", "unknown"};
  if (std::ranges::find(kFast, facts.clocksource) != kFast.end()) {
    return {Grade::kGood, "clock", fact};
  }
  return {
      Grade::kWrong, "clock", fact + ": slow to read, each tick reads it several times",
      "as root: echo tsc > /sys/devices/system/clocksource/clocksource0/current_clocksource; if "
      "the kernel refuses, dmesg says why it distrusts the tsc"};
}

Finding governor_of(const MachineFacts& facts) {
  constexpr const char* kSubject = "CPU governor";
  if (facts.governors.empty()) {
    return {Grade::kGood, kSubject, "none here (a virtual machine, or the firmware decides)"};
  }
  const std::string fact = joined(facts.governors, shown);
  if (facts.governors == std::vector<std::string>{"performance"}) {
    return {Grade::kGood, kSubject, fact};
  }
  return {Grade::kHint, kSubject, fact + ": cores slow down between ticks, wake-ups are later",
          "as root: cpupower frequency-set -g performance (apt install linux-cpupower)"};
}

Finding cores_of(const MachineFacts& facts) {
  constexpr const char* kSubject = "isolated cores";
  const auto list = [](const std::string& cores) { return cores.empty() ? "none" : shown(cores); };
  if (facts.isolated.empty() && facts.nohz_full.empty()) {
    return {Grade::kHint, kSubject, "none: the servo shares its core with everything",
            "where ticks are late, start the kernel with isolcpus=3 nohz_full=3 (a core of "
            "yours) and run `taskset -c 3 hapticd …`"};
  }
  return {Grade::kGood, kSubject,
          "isolcpus " + list(facts.isolated) + ", nohz_full " + list(facts.nohz_full)};
}

Finding runtime_of(const RuntimeFolder& folder) {
  const auto finding = [&](Grade grade, const char* fact, const char* mend) {
    return Finding{grade, "runtime folder", shown(folder.path) + fact, mend};
  };
  if (!folder.is_folder) {
    return finding(Grade::kWrong, " is no folder", "remove it, or set HAPTICD_RUNTIME_DIR");
  }
  if (!folder.is_ours) {
    return finding(Grade::kWrong, " belongs to another user",
                   "set HAPTICD_RUNTIME_DIR to a folder of your own");
  }
  if (!folder.writable) {
    return finding(Grade::kWrong, folder.exists ? " may not be written" : " cannot be made",
                   "set HAPTICD_RUNTIME_DIR to a folder that you may write");
  }
  return finding(Grade::kGood, folder.exists ? " is yours" : " will be made by the first session",
                 "");
}

Finding rules_of(const MachineFacts& facts) {
  if (facts.rules_installed) return {Grade::kGood, "udev rules", "installed", ""};
  const bool needed = std::ranges::any_of(facts.devices, is_certain);
  return {needed ? Grade::kWrong : Grade::kHint, "udev rules",
          "70-hapticd.rules is not installed: devices are root's, may be suspended, and "
          "ModemManager talks to serial ones",
          kMendRules};
}

Finding spacenavd_of(const MachineFacts& facts) {
  if (facts.spacenavd.empty()) return {Grade::kGood, "spacenavd", "not running", ""};
  return {Grade::kHint, "spacenavd",
          "running (pid " + std::to_string(facts.spacenavd.front().pid) +
              "): it moves the pointer and other programs while hapticd reads the same knob",
          "systemctl stop spacenavd"};
}

std::string name_of(const ListedDevice& device) {
  const bool known = device.rows.size() == 1 && !device.other_product;
  return (known ? std::string(device.rows.front().name) : "serial port") + " at " +
         shown(device.node.path);
}

void add_device(const MachineFacts& facts, const ListedDevice& device,
                std::vector<Finding>& findings) {
  if (device.other_product) return;
  const std::string name = name_of(device);
  const Obstacle obstacle = obstacle_of(device.node, device.access);
  // behind a serial port there may be anything
  const Grade bad = is_certain(device) ? Grade::kWrong : Grade::kHint;
  const Grade grade = obstacle.problem.empty() ? Grade::kGood
                      : obstacle.blocks        ? bad
                                               : Grade::kHint;
  findings.push_back(
      {grade, name, obstacle.problem.empty() ? "can be opened" : obstacle.problem, obstacle.mend});
  if (device.access.power == "auto") {
    findings.push_back({bad, name,
                        "may be suspended by the kernel when it is idle, and wakes up late",
                        "as root: echo on > /sys/bus/usb/devices/" + shown(device.node.port) +
                            "/power/control; hapticd's udev rules do it each time"});
  }
  if (device.access.driver == "logitech") {
    findings.push_back({Grade::kGood, name,
                        "bound to hid-logitech, which leaves the reports that hapticd reads as "
                        "they are",
                        ""});
  }
  if (device.node.kind == NodeKind::kSerial && !facts.modem_manager.empty() &&
      !facts.rules_installed) {
    findings.push_back({bad, name,
                        "ModemManager sends it bytes when it is plugged in, to see whether it is a "
                        "modem",
                        kMendRules});
  }
}

constexpr std::array kGradeWords{"good", "hint", "wrong"};  // by Grade

const char* finding_word(Grade grade) {
  return kGradeWords[static_cast<size_t>(grade)];
}

}  // namespace

std::vector<Finding> findings_of(const MachineFacts& facts) {
  std::vector<Finding> findings{priority_of(facts),   memory_of(facts),          kernel_of(facts),
                                throttling_of(facts), clock_of(facts),           governor_of(facts),
                                cores_of(facts),      runtime_of(facts.runtime), rules_of(facts),
                                spacenavd_of(facts)};
  if (!facts.udev_problem.empty()) {
    findings.push_back({Grade::kWrong, "devices", facts.udev_problem,
                        "run on the machine itself, or pass /sys and /dev into the container"});
  } else if (facts.devices.empty()) {
    findings.push_back({Grade::kHint, "devices", "none is plugged in that hapticd drives",
                        "`hapt devices` lists those that it supports"});
  }
  for (const ListedDevice& device : facts.devices) add_device(facts, device, findings);
  return findings;
}

bool is_any_wrong(const std::vector<Finding>& findings) {
  return std::ranges::any_of(findings,
                             [](const Finding& one) { return one.grade == Grade::kWrong; });
}

void print_findings(const std::vector<Finding>& findings, std::ostream& out) {
  for (const Finding& one : findings) {
    out << padded(one.grade == Grade::kWrong ? "WRONG" : finding_word(one.grade), 7) << one.subject
        << ": " << one.fact << '\n';
    if (!one.mend.empty()) out << "       mend: " << one.mend << '\n';
  }
  const auto wrong = std::ranges::count(findings, Grade::kWrong, &Finding::grade);
  out << '\n'
      << (wrong == 0
              ? std::string("nothing is wrong")
              : std::to_string(wrong) + (wrong == 1 ? " thing is" : " things are") + " wrong")
      << '\n';
}

void print_findings_json(const std::vector<Finding>& findings, std::ostream& out) {
  Json all = Json::array();
  for (const Finding& one : findings) {
    all.push_back({{"grade", finding_word(one.grade)},
                   {"subject", one.subject},
                   {"fact", one.fact},
                   {"mend", one.mend}});
  }
  out << json_lines(all);
}

}  // namespace haptic
