// SPDX-License-Identifier: Apache-2.0
#include "clients/library/client.h"

#include <utility>

namespace haptic {

Client::Client(const std::string& session)
    : attachments_(connect_session(session), eyes_.options()) {}

void Client::sleep(double seconds) const {
  sleep_until(now_ns() + static_cast<int64_t>(seconds * static_cast<double>(kNsPerSecond)));
}

}  // namespace haptic
