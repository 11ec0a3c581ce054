// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/lead.h"

namespace haptic {

std::optional<Vec3> led_handle(const DeviceMap& map, const Clutch& clutch,
                               const DeviceState& device, const ControlFrame* control,
                               int64_t now_ns) {
  if (control == nullptr || control->leading == 0) return std::nullopt;
  const int64_t t_ns = control->intent_t_ns;
  // a command may be given after the tick's wake-up
  if (t_ns < now_ns - kLeadNs || t_ns > now_ns + kLeadNs) return std::nullopt;
  const Vec3 p_BH = handle_position(map, clutch, control->X_WT_intent.p, device.X_BH.q);
  if (!is_finite(p_BH)) return std::nullopt;
  return p_BH;
}

}  // namespace haptic
