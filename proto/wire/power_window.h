// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>

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
    PowerWindow then = *this;
    then.move_to(t_ns);
    return std::accumulate(then.bins_.begin(), then.bins_.end(), 0.0);
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
