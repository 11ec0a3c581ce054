// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>

namespace haptic {

/// How far a device is believed: a bucket of doubt. What it should not have said adds a weight,
/// each good answer takes away one. At `most` the device is distrusted, until no doubt is left, so
/// that an honest one on a busy machine is not, and a liar cannot win trust back by a few good
/// answers.
class Trust {
 public:
  /// Doubt of one odd answer, where nothing better is known: 32 good ones make up for it, since an
  /// honest device errs far less often. Eight in a row are no accident.
  static constexpr int kOdd = 32, kMost = 8 * kOdd;

  constexpr explicit Trust(int most = kMost) : most_(most) {}

  /// Doubt by a weight more; negative: less.
  constexpr void doubt(int weight) noexcept {
    doubt_ = std::clamp(doubt_ + weight, 0, most_);
    lost_ = doubt_ == most_ || (lost_ && doubt_ > 0);
  }
  /// The doubt of one answer.
  constexpr void judge(bool good) noexcept { doubt(good ? -1 : kOdd); }

  /// The device is distrusted.
  constexpr bool is_lost() const noexcept { return lost_; }
  /// There is no doubt at all.
  constexpr bool is_whole() const noexcept { return doubt_ == 0; }

 private:
  int most_;
  int doubt_ = 0;
  bool lost_ = false;
};

}  // namespace haptic
