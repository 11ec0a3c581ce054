// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>

#include "clients/view/view.h"

namespace haptic {

/// The bridge's counts of its viewers.
struct BridgeCounts {
  uint64_t viewers = 0, connections = 0;
  uint64_t frames_sent = 0, frames_skipped = 0;
  uint64_t reconnects = 0;  // to a hapticd that was started again
};

/// The text of /metrics, in the exposition format 0.0.4 of Prometheus.
std::string metrics_text(const View& view, const BridgeCounts& counts, bool is_connected);

}  // namespace haptic
