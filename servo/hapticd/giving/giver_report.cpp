// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/giving/giver_report.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

#include "proto/os/message.h"
#include "proto/wire/giving.h"

namespace haptic {

GiverReport giver_report(const ClientConfig& client, uint32_t number, const GiverSeat& seat,
                         std::span<const std::span<const GiverState>> taken) {
  GiverReport report{.name = std::string(view(client.name)), .pid = seat.pid, .words = {}};
  if (!seat.is_taken) report.pid = -1;
  const auto say = [&](std::string words) {
    // sim and contact may say the same
    if (std::ranges::find(report.words, words) == report.words.end()) {
      report.words.push_back(std::move(words));
    }
  };
  for (const std::span<const GiverState> givers : taken) {
    const auto found = std::ranges::find(givers, number, &GiverState::client);
    if (found == givers.end()) continue;
    if (found->period_ns > 0) report.rate = 1e9 / static_cast<double>(found->period_ns);
    report.refused = std::max(report.refused, found->refused);
    for (const GiverFlagRow& row : kGiverFlags) {
      const bool is_set = (found->flags & row.flag) != 0;
      if (is_set && (seat.is_taken || row.flag != kGiverLate)) say(std::string(row.words));
    }
    if (seat.is_taken && found->refusal != 0) {
      say("refused: " + std::string(words_of(static_cast<GiverRefusal>(found->refusal))));
    }
  }
  return report;
}

std::string giver_text(const GiverReport& giver) {
  std::string text = giver.pid < 0 ? "is not there" : fmt::format("gives, pid {}", giver.pid);
  if (giver.pid >= 0 && giver.rate > 0) text += fmt::format(", {:.0f} Hz", giver.rate);
  for (const std::string& word : giver.words) text += "; " + word;
  return text;
}

}  // namespace haptic
