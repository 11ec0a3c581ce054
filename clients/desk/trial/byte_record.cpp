// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/desk/trial/byte_record.h"

#include "proto/os/realtime.h"

namespace haptic {

ByteRecord::ByteRecord() {
  pieces_.reserve(kMostPieces);
}

bool ByteRecord::listen_to(Device& device) {
  begin_ns_ = now_ns();
  return device.tap(
      [this](bool by_device, std::span<const uint8_t> bytes) { add(by_device, bytes); });
}

void ByteRecord::add(bool by_device, std::span<const uint8_t> bytes) {
  cut_ |= pieces_.size() == kMostPieces;
  if (cut_) return;
  pieces_.push_back({now_ns() - begin_ns_, by_device, std::string(bytes.begin(), bytes.end())});
}

}  // namespace haptic
