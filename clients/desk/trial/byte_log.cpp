// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/desk/trial/byte_log.h"

#include <charconv>
#include <istream>
#include <ostream>
#include <sstream>

#include "proto/os/message.h"

namespace haptic {
namespace {

std::string from_hex(const std::string& text) {
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

}  // namespace

void write_device_bytes(const std::vector<DeviceBytes>& pieces, std::ostream& out) {
  constexpr const char* kDigits = "0123456789abcdef";
  out << kDeviceBytesHeader << '\n';
  for (const DeviceBytes& piece : pieces) {
    out << piece.t_ns << (piece.by_device ? " < " : " > ");
    for (const char c : piece.bytes) {
      const auto byte = static_cast<unsigned char>(c);
      out << kDigits[byte >> 4] << kDigits[byte & 15];
    }
    out << '\n';
  }
}

std::vector<DeviceBytes> read_device_bytes(std::istream& in) {
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

}  // namespace haptic
