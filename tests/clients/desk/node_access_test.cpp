// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for clients/desk/node_access.cpp and machine_facts.cpp in a folder like a machine's root.
#include "clients/desk/node_access.h"

#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <limits>

#include "clients/desk/machine_facts.h"
#include "proto/os/file_descriptor.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

namespace fs = std::filesystem;

/// A root folder whose files a test writes.
class Root {
 public:
  std::string path() const { return folder_.path(); }

  void write(const std::string& file, const std::string& text) const {
    fs::create_directories(fs::path(path() + file).parent_path());
    std::ofstream(path() + file) << text;
  }
  void link(const std::string& file, const std::string& to) const {
    fs::create_directories(fs::path(path() + file).parent_path());
    fs::create_symlink(to, path() + file);
  }
  void process(int pid, const std::string& name, const std::string& open_file = "") const {
    const std::string folder = "/proc/" + std::to_string(pid);
    write(folder + "/comm", name + "\n");
    link(folder + "/fd/0", "/dev/null");
    if (!open_file.empty()) link(folder + "/fd/7", open_file);
  }

 private:
  test::TemporaryFolder folder_;
};

const PluggedNode kHid{NodeKind::kHid, "/dev/hidraw3", 0x256f, 0xc635, "", "1-2", "", ""};

}  // namespace

TEST_CASE("node access: a node that is not there, and one that is") {
  const Root root;
  CHECK_FALSE(read_access(root.path(), kHid).exists);
  root.write("/dev/hidraw3", "");
  const NodeAccess access = read_access(root.path(), kHid);
  CHECK(access.exists);
  CHECK(access.allowed);
  CHECK(access.driver.empty());
  CHECK(access.power.empty());
  CHECK(access.holders.empty());
}

TEST_CASE("node access: who has a node open, which driver has the interface, what may suspend it") {
  const Root root;
  root.write("/dev/hidraw3", "");
  root.process(71, "bash");
  root.process(812, "spacenavd", "/dev/hidraw3");
  root.process(9, "reader", "/dev/hidraw30");
  root.process(getpid(), "hapt", "/dev/hidraw3");  // who asks is in nobody's way
  root.link("/sys/class/hidraw/hidraw3/device/driver", "../../../../bus/hid/drivers/logitech");
  root.link("/sys/bus/usb/devices/1-2:1.0/driver", "../../../../bus/usb/drivers/usbhid");
  root.link("/sys/bus/usb/devices/1-20:1.0/driver", "../../../../bus/usb/drivers/usbfs");
  root.write("/sys/bus/usb/devices/1-2/power/control", "auto\n");
  const NodeAccess access = read_access(root.path(), kHid);
  REQUIRE(access.holders.size() == 1);
  CHECK(access.holders[0].pid == 812);
  CHECK(access.holders[0].name == "spacenavd");
  CHECK(access.driver == "logitech");
  CHECK(access.power == "auto");
  PluggedNode usb = kHid;
  usb.kind = NodeKind::kUsb;
  CHECK(read_access(root.path(), usb).driver == "usbhid");
  CHECK(processes_named(root.path(), "spacenavd").size() == 1);
  CHECK(processes_named(root.path(), "space").empty());
}

TEST_CASE("node access: the kernel's list of locks tells that a serial line is driven") {
  const Root root;
  root.write("/dev/ttyACM0", "");
  const PluggedNode node{NodeKind::kSerial, "/dev/ttyACM0", 0, 0, "", "1-2", "", ""};
  const FileDescriptor line(open((root.path() + node.path).c_str(), O_RDWR | O_CLOEXEC));
  const auto copy_locks = [&] {
    std::ifstream now("/proc/locks");
    root.write("/proc/locks", std::string(std::istreambuf_iterator<char>(now), {}));
  };
  copy_locks();
  CHECK_FALSE(read_access(root.path(), node).locked);
  REQUIRE(flock(line.get(), LOCK_EX) == 0);
  copy_locks();
  CHECK(read_access(root.path(), node).locked);
}

TEST_CASE("node access: each obstacle has its words, and its mend") {
  const auto blocked = [](const PluggedNode& node, const NodeAccess& access) {
    const Obstacle obstacle = obstacle_of(node, access);
    CHECK(obstacle.problem.empty() == obstacle.mend.empty());
    return std::pair(obstacle.problem, obstacle.blocks);
  };
  const std::vector<Holder> spacenavd{{812, "spacenavd"}}, servo{{5, "haptic-servo"}};
  CHECK(blocked(kHid, {}) == std::pair(std::string("its node is not there"), true));
  CHECK(blocked(kHid, {.exists = true}) ==
        std::pair(std::string("this user may not open it"), true));
  CHECK(obstacle_of(kHid, {.exists = true}).mend.find("70-hapticd.rules") != std::string::npos);
  CHECK(blocked(kHid, {.exists = true, .allowed = true}) == std::pair(std::string(), false));
  CHECK(
      blocked(kHid, {.exists = true, .allowed = true, .holders = spacenavd}) ==
      std::pair(std::string("read by spacenavd (pid 812) too, which may also command it"), false));
  CHECK(blocked(kHid, {.exists = true, .allowed = true, .holders = servo}) ==
        std::pair(std::string("a session of hapticd drives it"), true));

  PluggedNode usb = kHid;
  usb.kind = NodeKind::kUsb;
  // the driver of the kernel is detached by ours; a program's claim is not
  CHECK(blocked(usb, {.exists = true, .allowed = true, .driver = "ftdi_sio"}).second == false);
  CHECK(blocked(usb, {.exists = true, .allowed = true, .driver = "usbfs"}) ==
        std::pair(std::string("another program drives it"), true));
  PluggedNode serial = kHid;
  serial.kind = NodeKind::kSerial;
  CHECK(blocked(serial, {.exists = true, .allowed = true, .locked = true}).second);
  CHECK(blocked(serial, {.exists = true, .allowed = true, .holders = {{3, "minicom\x1b[2J"}}}) ==
        std::pair(std::string("another program drives it: minicom\\x1b[2J (pid 3)"), true));
}

TEST_CASE("machine facts: a root without files says nothing, and nothing is invented") {
  const Root root;
  const MachineFacts facts = read_machine(root.path(), root.path() + "/run/hapticd");
  CHECK(facts.capabilities == 0);
  CHECK_FALSE(facts.realtime_priority.has_value());
  CHECK_FALSE(facts.locked_memory.has_value());
  CHECK(facts.clocksource.empty());
  CHECK(facts.governors.empty());
  CHECK_FALSE(facts.rules_installed);
  CHECK_FALSE(facts.virtual_machine);
  CHECK_FALSE(facts.runtime.exists);
}

TEST_CASE("machine facts: as the kernel writes them") {
  const Root root;
  root.write("/proc/self/status", "Name:\thapt\nCapInh:\t0\nCapEff:\t0000000000804000\n");
  root.write("/proc/self/limits",
             "Limit                     Soft Limit           Hard Limit           Units     \n"
             "Max locked memory         8388608              unlimited            bytes     \n"
             "Max realtime priority     95                   99                             \n");
  root.write("/proc/sys/kernel/osrelease", "6.1.0-21-rt-amd64\n");
  root.write("/proc/sys/kernel/version", "#1 SMP PREEMPT_RT Debian 6.1.90-1\n");
  root.write("/proc/sys/kernel/sched_rt_runtime_us", "-1\n");
  root.write("/proc/sys/kernel/sched_rt_period_us", "1000000\n");
  root.write("/proc/cpuinfo", "processor\t: 0\nflags\t\t: fpu vme hypervisor lahf_lm\n");
  const std::string system = "/sys/devices/system/";
  root.write(system + "clocksource/clocksource0/current_clocksource", "hpet\n");
  root.write(system + "cpu/isolated", "2-3\n");
  root.write(system + "cpu/nohz_full", "(null)\n");
  root.write(system + "cpu/cpu0/cpufreq/scaling_governor", "powersave\n");
  root.write(system + "cpu/cpu1/cpufreq/scaling_governor", "performance\n");
  root.write(system + "cpu/cpu2/cpufreq/scaling_governor", "powersave\n");
  root.write("/usr/lib/udev/rules.d/70-hapticd.rules", "");
  root.process(44, "ModemManager");
  const MachineFacts facts = read_machine(root.path(), root.path());
  CHECK(facts.capabilities == 0x804000);
  CHECK(facts.realtime_priority == 95);
  CHECK(facts.locked_memory == 8388608u);
  CHECK(facts.kernel_release == "6.1.0-21-rt-amd64");
  CHECK(facts.realtime_share_us == -1);
  CHECK(facts.virtual_machine);
  CHECK(facts.clocksource == "hpet");
  CHECK(facts.isolated == "2-3");
  CHECK(facts.nohz_full.empty());
  CHECK(facts.governors == std::vector<std::string>{"performance", "powersave"});
  CHECK(facts.rules_installed);
  CHECK(facts.modem_manager.size() == 1);
  CHECK(facts.runtime.exists);
  CHECK(facts.runtime.is_ours);

  root.write("/proc/self/limits", "Max locked memory         unlimited  unlimited  bytes\n");
  CHECK(read_machine(root.path(), "").locked_memory == std::numeric_limits<uint64_t>::max());
}

}  // namespace haptic
