// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/leads.h"

#include <string>

#include "proto/os/realtime.h"

namespace haptic {

void Leads::take(std::string_view line) {
  const bool was_led = until_ns_.has_value(), is_led = session_.desired.frame.leading != 0;
  const int64_t t_ns = now_ns();
  until_ns_.reset();
  if (is_led) {
    session_.desired.frame.intent_t_ns = t_ns;
    until_ns_ = t_ns + kLeadNs;
  }
  session_.desired.publish(t_ns);
  if (is_led == was_led) return;
  session_.log.write(
      LogLevel::kInfo, "hapticd",
      is_led ? "somebody leads the hand: " + std::string(line) : "nobody leads the hand");
}

void Leads::look(int64_t t_ns) {
  if (!until_ns_ || t_ns <= *until_ns_) return;
  until_ns_.reset();
  session_.desired.frame.leading = 0;
  session_.desired.change(t_ns);
  session_.log.write(LogLevel::kInfo, "hapticd",
                     "nobody leads the hand any more: no command for 200 ms");
}

}  // namespace haptic
