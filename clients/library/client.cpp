// SPDX-License-Identifier: Apache-2.0
#include "clients/library/client.h"

#include <filesystem>
#include <utility>

#include "proto/ipc/sessions.h"

namespace haptic {
namespace {

constexpr int64_t kRetryPeriod =
    kNsPerSecond / 10;  // [ns], between attempts to attach; a person does not notice it

}  // namespace

Client::Client(const std::string& session) : Client(connect_session(session)) {}

Client::Client(FileDescriptor socket)
    : attachments_(std::move(socket), eyes_.options()),
      control_(attachments_.source<ControlChannels>()) {}

bool has_ended(const SegmentHeader* control) noexcept {
  return control != nullptr && control->state.load() == static_cast<uint32_t>(SegmentState::kDead);
}

bool Client::has_ended() noexcept {
  control_.channels();
  return haptic::has_ended(control_.header());
}

void Client::sleep(double seconds) const {
  sleep_until(now_ns() + static_cast<int64_t>(seconds * static_cast<double>(kNsPerSecond)));
}

FileDescriptor connect_again(const std::string& session, const std::function<bool()>& stop) {
  for (; !stop || !stop(); sleep_until(now_ns() + kRetryPeriod)) {
    try {
      return connect_session(session);
    } catch (const HandoutError&) {
      // not yet
    }
  }
  return {};
}

Client* Reconnect::next(const std::function<bool()>& stop) {
  if (client_ == nullptr) {
    // the name alone: another session may be the only one later
    session_ = std::filesystem::path(find_session(session_)).stem().string();
    client_ = std::make_unique<Client>(connect_session(session_));
    return client_.get();
  }
  if (!client_->refusal().empty()) throw HandoutError(client_->refusal());
  const bool has_ended = client_->has_ended();
  const int64_t gone_ns = now_ns();
  client_.reset();
  if (has_ended) return nullptr;
  FileDescriptor socket = connect_again(session_, stop);
  if (!socket.is_open()) return nullptr;
  client_ = std::make_unique<Client>(std::move(socket));
  missed_ = static_cast<double>(now_ns() - gone_ns) / static_cast<double>(kNsPerSecond);
  return client_.get();
}

}  // namespace haptic
