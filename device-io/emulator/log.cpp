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
    "t_ns,event,motors_on,commands,rejected,watchdog,a_mA,b_mA,c_mA,d_mA,e_mA,f_mA,fx_N,fy_N,fz_N,"
    "tx_Nm,ty_Nm,tz_Nm,x_m,y_m,z_m,qx,qy,qz,qw,e0,e1,e2,e3,e4,e5,answered0,answered1,answered2,"
    "answered3,answered4,answered5,first0,first1,first2,first3,first4,first5\n";

/// A row, one cell at a time.
class Row {
 public:
  explicit Row(std::FILE* file) : file_(file) {}

  void put(uint64_t n) { note(std::fprintf(file_, "%s%" PRIu64, separator_, n)); }
  void put(int64_t n) { note(std::fprintf(file_, "%s%" PRId64, separator_, n)); }
  void put(double a) { note(std::fprintf(file_, "%s%.9g", separator_, a)); }
  void put(const Vec3& a) {
    for (int i = 0; i < 3; ++i) put(a[i]);
  }
  void put(const std::array<int32_t, kMostMotors>& counts) {
    for (const int32_t n : counts) put(int64_t{n});
  }
  bool end() {
    note(std::fputc('\n', file_));
    return good_;
  }

 private:
  void note(int result) {
    good_ = result >= 0 && good_;
    separator_ = ",";
  }

  std::FILE* file_;
  const char* separator_ = "";
  bool good_ = true;
};

bool print(std::FILE* file, const EmulatorRecord& r) {
  Row row(file);
  row.put(r.t_ns);
  row.put(uint64_t{static_cast<uint32_t>(r.event)});
  row.put(uint64_t{r.motors_on});
  for (const uint64_t n : {r.commands, r.rejected, r.watchdog}) row.put(n);
  row.put(r.currents);
  for (const Vec3& a : {r.force_B, r.torque_B, r.p_B, r.q_B.vector()}) row.put(a);
  row.put(r.q_B.w);
  for (const MotorCounts& counts : {r.counts, r.answered, r.said_first}) row.put(counts);
  return row.end();
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
