// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "proto/config/client_config.h"
#include "servo/hapticd/giving/give_server.h"

namespace haptic {

/// What the status says of a client that may give.
struct GiverReport {
  std::string name;
  pid_t pid = -1;                  // −1: it is not there
  double rate = 0;                 // of its frames [Hz]; 0: not known
  uint64_t refused = 0;            // frames
  std::vector<std::string> words;  // what is wrong; empty: nothing
};

/// By whose seat it is, and what sim and the hands' contacts have taken of it (GiverState).
GiverReport giver_report(const ClientConfig& client, uint32_t number, const GiverSeat& seat,
                         std::span<const std::span<const GiverState>> taken);

/// One line without its name: "gives, pid 5, 100 Hz" or "is not there".
std::string giver_text(const GiverReport& giver);

}  // namespace haptic
