// SPDX-License-Identifier: Apache-2.0
#include "clients/log/log_columns.h"

#include <sstream>

namespace haptic {

LogColumn column_of_comparison(const std::string& name) {
  const std::string root = "/" + name;
  return {name, root + "/servo/frame", root + "/contact/set", root + "/sim/frame"};
}

std::vector<LogColumn> log_columns(const TraceReader& trace) {
  std::vector<LogColumn> wanted;
  if (trace.mcap().metadata().contains("comparison")) {
    std::istringstream names(trace.mcap().metadata("comparison", "columns"));
    for (std::string name; std::getline(names, name, ',');) {
      wanted.push_back(column_of_comparison(name));
    }
  } else {
    for (uint32_t hand = kFirstHand; hand < kMostHands; ++hand) {
      const std::string name =
          hand == kFirstHand ? std::string(kSessionColumn) : "hand " + std::to_string(hand);
      wanted.push_back({name, std::string(servo_topic(hand).name),
                        std::string(contact_topic(hand).name), std::string(kSimTopic.name)});
    }
  }
  std::erase_if(wanted, [&](const LogColumn& column) {
    return trace.mcap().find_channel(column.servo) == nullptr;
  });
  return wanted;
}

}  // namespace haptic
