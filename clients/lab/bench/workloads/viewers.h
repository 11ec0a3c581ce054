// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

namespace haptic {

/// Counters of the viewers, in memory that they share with the bench.
struct ViewerCounts {
  std::atomic<uint32_t> connected;
  std::atomic<uint64_t> frames;
};

enum class ViewerKind { kPrompt, kSlow };

/// Is `n` pages of `hapt view` at 120 Hz until it is killed, without drawing anything: a prompt one
/// says at once that a frame is shown, a slow one reads a byte in a tenth of a second. Throws
/// std::runtime_error where the bridge refuses one.
void be_viewers(uint16_t port, int n, ViewerKind kind, ViewerCounts& counts);

}  // namespace haptic
