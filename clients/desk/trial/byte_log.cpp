// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/desk/trial/byte_log.h"

#include <ostream>

#include "proto/os/message.h"

namespace haptic {

void write_device_bytes(const std::vector<DeviceBytes>& pieces, std::ostream& out,
                        const std::vector<std::string>& remarks) {
  constexpr const char* kDigits = "0123456789abcdef";
  out << kDeviceBytesHeader << '\n';
  for (const std::string& remark : remarks) out << "# " << one_line(remark) << '\n';
  for (const DeviceBytes& piece : pieces) {
    out << piece.t_ns << (piece.by_device ? " < " : " > ");
    for (const char c : piece.bytes) {
      const auto byte = static_cast<unsigned char>(c);
      out << kDigits[byte >> 4] << kDigits[byte & 15];
    }
    out << '\n';
  }
}

}  // namespace haptic
