// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/emulator/log.h"

#include <cerrno>
#include <cinttypes>
#include <cstring>
#include <stdexcept>
#include <type_traits>

#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int64_t kPeriodNs = 5'000'000;  // between writes to the file
constexpr const char* kHeader =
    "t_ns,event,motors_on,commands,rejected,watchdog,a_mA,b_mA,c_mA,d_mA,e_mA,f_mA,fx_N,fy_N,fz_N,"
    "tx_Nm,ty_Nm,tz_Nm,x_m,y_m,z_m,qx,qy,qz,qw,e0,e1,e2,e3,e4,e5,answered0,answered1,answered2,"
    "answered3,answered4,answered5,first0,first1,first2,first3,first4,first5\n";

bool print(std::FILE* file, const EmulatorRecord& record) {
  bool good = true;
  const char* separator = "";
  each_cell(record, [&](auto number) {
    using Number = decltype(number);
    int written = 0;
    if constexpr (std::is_same_v<Number, double>) {
      written = std::fprintf(file, "%s%.9g", separator, number);
    } else if constexpr (std::is_same_v<Number, uint64_t>) {
      written = std::fprintf(file, "%s%" PRIu64, separator, number);
    } else {
      written = std::fprintf(file, "%s%" PRId64, separator, static_cast<int64_t>(number));
    }
    good = written >= 0 && good;
    separator = ",";
  });
  return std::fputc('\n', file) >= 0 && good;
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
    good_ = print(file_, record) && good_;
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
