// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <charconv>
#include <istream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "clients/desk/trial/byte_log.h"
#include "proto/os/message.h"

/// Reads the reports that `hapt devices try` writes, as people send them in.
namespace haptic::test {

inline std::string from_hex(const std::string& text) {
  std::string bytes;
  for (size_t i = 0; i + 1 < text.size(); i += 2) {
    unsigned value = 0;
    const char* end = text.data() + i + 2;
    const auto result = std::from_chars(text.data() + i, end, value, 16);
    if (result.ec != std::errc{} || result.ptr != end) return {};
    bytes += static_cast<char>(value);
  }
  return text.size() % 2 == 0 ? bytes : "";
}

/// Throws InputError with the number of the line that is wrong.
inline std::vector<DeviceBytes> read_device_bytes(std::istream& in) {
  std::string line;
  if (!std::getline(in, line) || line != kDeviceBytesHeader) {
    throw InputError(std::string("no bytes of a device: the first line is not '") +
                     kDeviceBytesHeader + "'");
  }
  std::vector<DeviceBytes> pieces;
  for (int number = 2; std::getline(in, line); ++number) {
    if (line.empty() || line.starts_with('#')) continue;
    std::istringstream words(line);
    DeviceBytes piece;
    std::string who, hex, more;
    words >> piece.t_ns >> who >> hex;
    piece.by_device = who == "<";
    piece.bytes = from_hex(hex);
    const bool in_order = pieces.empty() || piece.t_ns >= pieces.back().t_ns;
    if (!words || words >> more || (who != "<" && who != ">") || piece.bytes.empty() || !in_order) {
      throw InputError("line " + std::to_string(number) + ": '" + shown(line) +
                       "' is no later 't_ns < hex' or 't_ns > hex'");
    }
    pieces.push_back(std::move(piece));
  }
  return pieces;
}

}  // namespace haptic::test
