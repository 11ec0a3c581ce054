// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "clients/view/view.h"
#include "proto/config/out_of_reach.h"

/// The text messages to a page (docs/view-protocol.md).
namespace haptic {

/// `missed`: how long nothing was seen, in seconds; below zero: this is the first. `columns`: empty
/// means one, of the session's name.
std::string hello_message(const std::string& source, const std::string& session, double missed,
                          const std::vector<std::string>& columns = {});
std::string gone_message(const std::string& text);
std::string control_message(bool allowed, const std::string& reason);
/// `id` is JSON already.
std::string answer_message(const std::string& id, bool ok, const std::string& text);

/// The part of `hapt status --json` that pages show; hapticd is asked once a second.
struct SessionWords {
  struct Giver {
    std::string name, text;
    bool is_well = true;
  };
  int clients = 0;
  std::vector<Giver> giving;
  std::vector<std::string> closed_by;  // "what (remedy)"
  OutOfReach gone;
};
/// Never throws: what is not understood is left out.
SessionWords parse_status(std::string_view json);

std::string status_message(const View& view, const SessionWords& words, size_t viewers,
                           uint64_t missed);

}  // namespace haptic
