// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace haptic {

/// A piece of a conversation with a device.
struct DeviceBytes {
  int64_t t_ns = 0;  // since the conversation began
  bool by_device = false;
  std::string bytes;
  bool operator==(const DeviceBytes&) const = default;
};

/// Most pieces of a record: three minutes of 1 kHz in both directions, 40 MB.
inline constexpr size_t kMostPieces = 400'000;

/// First line of a file of such pieces. After it one piece a line, in the order of time: t_ns, then
/// '>' for the host's or '<' for the device's, then the bytes in hexadecimal; "120 > 5b305d0a".
/// Lines that begin with '#' are remarks.
inline constexpr const char* kDeviceBytesHeader = "# hapticd device bytes 1";

/// The remarks follow the first line.
void write_device_bytes(const std::vector<DeviceBytes>& pieces, std::ostream& out,
                        const std::vector<std::string>& remarks = {});

}  // namespace haptic
