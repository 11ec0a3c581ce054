// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/emulator/log_reader.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <stdexcept>

namespace haptic {
namespace {

/// Takes numbers from a row, one cell at a time.
struct Cells {
  std::string_view rest;
  bool good = true;

  template <typename Number>
  void take(Number& out) {
    const std::string_view cell = rest.substr(0, rest.find(','));
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), out);
    good = good && error == std::errc() && end == cell.data() + cell.size();
    rest.remove_prefix(std::min(cell.size() + 1, rest.size()));
  }
  void take(Vec3& out) {
    for (double* x : {&out.x, &out.y, &out.z}) take(*x);
  }
};

}  // namespace

EmulatorRecord parse_emulator_row(std::string_view row) {
  Cells cells{row};
  EmulatorRecord r{};
  uint32_t event = 0;
  cells.take(r.t_ns);
  cells.take(event);
  cells.take(r.motors_on);
  for (uint64_t* count : {&r.commands, &r.rejected, &r.watchdog}) cells.take(*count);
  for (int32_t& current : r.currents) cells.take(current);
  for (Vec3* a : {&r.force_B, &r.torque_B, &r.p_B}) cells.take(*a);
  for (double* x : {&r.q_B.x, &r.q_B.y, &r.q_B.z, &r.q_B.w}) cells.take(*x);
  for (int32_t& count : r.counts) cells.take(count);
  for (int32_t& count : r.answered) cells.take(count);
  for (int32_t& count : r.said_first) cells.take(count);
  r.event = static_cast<EmulatorEvent>(event);
  if (!cells.good || !cells.rest.empty()) {
    throw std::runtime_error("not a row of the emulator's log: " + std::string(row) +
                             "; give the file that haptic-emulator --log has written");
  }
  return r;
}

void EmulatorLogReader::read(std::vector<EmulatorRecord>& out) {
  if (file_ == nullptr) file_.reset(std::fopen(path_.c_str(), "re"));
  if (file_ == nullptr) return;
  std::clearerr(file_.get());
  std::array<char, 65536> bytes;
  while (const size_t n = std::fread(bytes.data(), 1, bytes.size(), file_.get())) {
    rest_.append(bytes.data(), n);
  }
  size_t begin = 0;
  for (size_t end; (end = rest_.find('\n', begin)) != std::string::npos; begin = end + 1) {
    if (!header_) out.push_back(parse_emulator_row({rest_.data() + begin, end - begin}));
    header_ = false;
  }
  rest_.erase(0, begin);
}

}  // namespace haptic
