// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

namespace haptic {

/// A set of lanes, iterated as: for (LaneSet s = …; s.any(); s.pop()) use(s.first()).
class LaneSet {
 public:
  explicit LaneSet(uint32_t bits) : bits_(bits) {}
  uint32_t bits() const { return bits_; }
  bool any() const { return bits_ != 0; }
  size_t first() const { return static_cast<size_t>(std::countr_zero(bits_)); }
  void pop() { bits_ &= bits_ - 1; }

 private:
  uint32_t bits_;
};

}  // namespace haptic
