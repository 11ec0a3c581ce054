// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace haptic {

/// Energy given in the last second, from instants to instants that ascend.
class PowerWindow {
 public:
  void add(double energy, int64_t t_ns) {
    move_to(t_ns);
    bins_[static_cast<size_t>(newest_) % kBins] += energy;
  }
  /// Energy of the second before t_ns [J].
  double energy(int64_t t_ns) const {
    const int64_t bin = t_ns / kBinNs;
    double sum = 0;
    for (size_t i = 0; i < kBins; ++i) {
      const int64_t at = newest_ - static_cast<int64_t>(i);
      if (bin - at < static_cast<int64_t>(kBins)) sum += bins_[static_cast<size_t>(at) % kBins];
    }
    return sum;
  }

 private:
  static constexpr size_t kBins = 20;
  static constexpr int64_t kBinNs = 1'000'000'000 / kBins;

  void move_to(int64_t t_ns) {
    const int64_t bin = t_ns / kBinNs;
    if (bin - newest_ >= static_cast<int64_t>(kBins)) {
      bins_ = {};
      newest_ = bin;
    }
    while (newest_ < bin) bins_[static_cast<size_t>(++newest_) % kBins] = 0;
  }
  std::array<double, kBins> bins_{};
  int64_t newest_ = kBins;  // number of the newest bin
};

}  // namespace haptic
