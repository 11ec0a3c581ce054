// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/emulator/line_workers.h"

#include <sched.h>

#include <charconv>
#include <filesystem>
#include <fstream>
#include <string>

#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int64_t kLookNs = 50'000'000;  // takes about 1 ms each time

/// Moves the kernel's unbound workers that have one priority to another; 0: the normal one. A
/// priority that somebody else has set is left alone.
void move_workers(int from, int to) {
  namespace fs = std::filesystem;
  const sched_param parameter{.sched_priority = to};
  std::error_code gone;  // processes may end meanwhile
  for (fs::directory_iterator it("/proc", gone), end; !gone && it != end; it.increment(gone)) {
    const std::string name = it->path().filename();
    int pid = 0;
    const auto parsed = std::from_chars(name.data(), name.data() + name.size(), pid);
    if (parsed.ptr != name.data() + name.size()) continue;
    std::string program;
    std::getline(std::ifstream(it->path() / "comm") >> std::ws, program);
    if (program.rfind("kworker/u", 0) != 0) continue;
    sched_param now{};
    if (sched_getparam(pid, &now) != 0 || now.sched_priority != from) continue;
    sched_setscheduler(pid, to > 0 ? SCHED_FIFO : SCHED_OTHER, &parameter);
  }
}

}  // namespace

LineWorkers::LineWorkers(int fifo_priority)
    : fifo_priority_(fifo_priority), thread_([this] { run(); }) {}

LineWorkers::~LineWorkers() {
  ending_ = true;
  thread_.join();
  move_workers(fifo_priority_, 0);
}

void LineWorkers::run() {
  while (!ending_) {
    move_workers(0, fifo_priority_);
    sleep_until(now_ns() + kLookNs);
  }
}

}  // namespace haptic
