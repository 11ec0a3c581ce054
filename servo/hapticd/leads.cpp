// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/leads.h"

#include <string>

#include "proto/os/realtime.h"

namespace haptic {

void Leads::take(uint32_t hand, std::string_view line) {
  DesiredState& desired = session_.desired[hand];
  std::optional<int64_t>& until_ns = until_ns_[hand];
  const bool was_led = until_ns.has_value(), is_led = desired.frame.leading != 0;
  const int64_t t_ns = now_ns();
  until_ns.reset();
  if (is_led) {
    desired.frame.intent_t_ns = t_ns;
    until_ns = t_ns + kLeadNs;
  }
  desired.publish(t_ns);
  if (is_led == was_led) return;
  session_.log.write(
      LogLevel::kInfo, "hapticd",
      is_led ? "somebody leads the hand: " + std::string(line) : "nobody leads the hand");
}

void Leads::look(int64_t t_ns) {
  for (uint32_t hand = 0; hand < session_.hands.size(); ++hand) {
    std::optional<int64_t>& until_ns = until_ns_[hand];
    if (!until_ns || t_ns <= *until_ns) continue;
    until_ns.reset();
    session_.desired[hand].frame.leading = 0;
    session_.desired[hand].change(t_ns);
    session_.log.write(LogLevel::kInfo, "hapticd",
                       "nobody leads the hand any more: no command for 200 ms");
  }
}

}  // namespace haptic
