// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/emulator/log_reader.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <stdexcept>
#include <type_traits>

#include "device-io/emulator/log.h"

namespace haptic {
EmulatorRecord parse_emulator_row(std::string_view row) {
  EmulatorRecord r{};
  std::string_view rest = row;
  bool good = true;
  const auto take = [&](auto& out) {
    const std::string_view cell = rest.substr(0, rest.find(','));
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), out);
    good = good && error == std::errc() && end == cell.data() + cell.size();
    rest.remove_prefix(std::min(cell.size() + 1, rest.size()));
  };
  each_cell(r, [&](auto& cell) {
    if constexpr (std::is_enum_v<std::remove_reference_t<decltype(cell)>>) {
      uint32_t number = 0;
      take(number);
      cell = static_cast<EmulatorEvent>(number);
    } else {
      take(cell);
    }
  });
  if (!good || !rest.empty()) {
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
