// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/emulator/log.h"

#include <cerrno>
#include <cinttypes>
#include <cstring>
#include <stdexcept>

#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int64_t kPeriodNs = 5'000'000;  // between writes to the file
constexpr const char* kHeader =
    "t_ns,event,motors_on,commands,rejected,watchdog,a_mA,b_mA,c_mA,fx_N,fy_N,fz_N,x_m,y_m,z_m,"
    "e0,e1,e2,answered0,answered1,answered2,first0,first1,first2\n";

int print(std::FILE* file, const EmulatorRecord& r) {
  const auto &i = r.currents, &e = r.counts, &a = r.answered, &s = r.said_first;
  return std::fprintf(file,
                      "%" PRId64 ",%u,%u,%" PRIu64 ",%" PRIu64 ",%" PRIu64
                      ",%d,%d,%d,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%d,%d,%d,%d,%d,%d,%d,%d,%d\n",
                      r.t_ns, static_cast<uint32_t>(r.event), r.motors_on, r.commands, r.rejected,
                      r.watchdog, i[0], i[1], i[2], r.force_B.x, r.force_B.y, r.force_B.z, r.p_B.x,
                      r.p_B.y, r.p_B.z, e[0], e[1], e[2], a[0], a[1], a[2], s[0], s[1], s[2]);
}

}  // namespace

EmulatorLog::EmulatorLog(const std::string& path) {
  if (path.empty()) return;
  file_ = std::fopen(path.c_str(), "we");
  if (file_ == nullptr || std::fputs(kHeader, file_) < 0) {
    throw std::runtime_error(path + ": cannot be written: " + std::strerror(errno) +
                             "; give --log another name");
  }
  thread_ = std::thread([this] { run(); });
}

EmulatorLog::~EmulatorLog() {
  finish();
}

void EmulatorLog::run() {
  while (!ending_.load(std::memory_order_acquire)) {
    drain();
    sleep_until(now_ns() + kPeriodNs);
  }
  drain();
}

void EmulatorLog::drain() {
  for (EmulatorRecord record; read_next(*ring_, cursor_, record); ++rows_) {
    good_ = print(file_, record) > 0 && good_;
  }
  good_ = std::fflush(file_) == 0 && good_;
}

EmulatorLog::Outcome EmulatorLog::finish() {
  if (file_ != nullptr) {
    ending_.store(true, std::memory_order_release);
    thread_.join();
    good_ = std::fclose(file_) == 0 && good_;
    file_ = nullptr;
  }
  return {rows_, cursor_.lost, good_};
}

}  // namespace haptic
