// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/lead.h"

namespace haptic {

std::optional<Pose> led_handle(const DeviceMap& map, const Clutch& clutch,
                               const ControlFrame* control, int64_t now_ns) {
  if (control == nullptr || control->leading == 0) return std::nullopt;
  const int64_t t_ns = control->intent_t_ns;
  // a command may be given after the tick's wake-up
  if (t_ns < now_ns - kLeadNs || t_ns > now_ns + kLeadNs) return std::nullopt;
  const Pose X_BH = handle_pose(map, clutch, control->X_WT_intent);
  if (!is_finite(X_BH) || !is_unit(X_BH.q)) return std::nullopt;
  return X_BH;
}

}  // namespace haptic
