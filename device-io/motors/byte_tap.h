// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <utility>

#include "device-io/device.h"

namespace haptic {

/// Whom a thread of transfers tells of what it says and hears. Set at most once, from any thread;
/// until then a call does nothing.
class ByteTap {
 public:
  void set(HearBytes hears) {
    hears_ = std::move(hears);
    set_.store(true, std::memory_order_release);
  }
  bool is_set() const noexcept { return set_.load(std::memory_order_acquire); }
  void operator()(bool by_device, std::span<const uint8_t> bytes, int64_t t_ns) const {
    if (is_set()) hears_(by_device, bytes, t_ns);
  }

 private:
  HearBytes hears_;
  std::atomic<bool> set_{false};
};

}  // namespace haptic
