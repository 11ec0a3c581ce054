// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/desk/trial/byte_record.h"

#include <algorithm>

#include "proto/os/realtime.h"

namespace haptic {

ByteRecord::ByteRecord() {
  pieces_.reserve(kMostPieces);
}

bool ByteRecord::listen_to(Device& device) {
  begin_ns_ = now_ns();
  return device.tap([this](bool by_device, std::span<const uint8_t> bytes, int64_t t_ns) {
    add(by_device, bytes, t_ns);
  });
}

void ByteRecord::add(bool by_device, std::span<const uint8_t> bytes, int64_t t_ns) {
  cut_ |= pieces_.size() == kMostPieces;
  if (cut_) return;
  // the instant of a tick may lie before that at which listening began
  const int64_t before_ns = pieces_.empty() ? 0 : pieces_.back().t_ns;
  pieces_.push_back(
      {std::max(before_ns, t_ns - begin_ns_), by_device, std::string(bytes.begin(), bytes.end())});
}

}  // namespace haptic
