// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "clients/view/view.h"

/// The protocol of Foxglove and Lichtblick, read-only: the records of a session as they are in a
/// recording (CDR, with their ros2msg schemas), the newest of each topic.
namespace haptic {

/// Names of the same protocol, the newer first; clients ask for one or the other.
inline constexpr std::array<const char*, 2> kFoxgloveProtocols{"foxglove.sdk.v1",
                                                               "foxglove.websocket.v1"};

std::string foxglove_server_info(const std::string& session);
/// The channels: one for each topic, numbered from 1 on.
std::string foxglove_advertise();

/// The subscriptions of a client: the channel of each, by the number of the subscription.
struct FoxgloveClient {
  std::map<uint32_t, uint32_t> channels;
  std::map<uint32_t, uint64_t> sent;  // the newest record that was sent, by subscription
};

/// Follows a text message of a client; returns why it is not followed, empty: it was. What the
/// bridge has not offered (publishing, parameters, services) is passed over.
std::string hear_foxglove(FoxgloveClient& client, std::string_view text);

/// A warning for the client's log.
std::string foxglove_warning(const std::string& text);

/// The messages that are newer than what the client has, one for each subscription at most.
std::vector<std::string> foxglove_messages(FoxgloveClient& client, const View& view);

}  // namespace haptic
