// SPDX-License-Identifier: Apache-2.0
#include "clients/c/calls.h"

namespace haptic {
namespace {

thread_local std::array<char, kMessageBytes> last{};

void keep(std::array<char, kMessageBytes>& place, std::string_view text) noexcept {
  const size_t length = std::min(text.size(), place.size() - 1);
  std::memmove(place.data(), text.data(), length);
  place[length] = '\0';
}

}  // namespace

const char* last_message() noexcept {
  return last.data();
}

hapticd_result fail(Handle* handle, hapticd_result result, std::string_view text) noexcept {
  keep(last, text);
  if (handle != nullptr) keep(handle->message, text);
  return result;
}

hapticd_result say_gone(bool is_connected, const std::string& refusal, bool has_ended) {
  if (is_connected) return HAPTICD_OK;
  if (!refusal.empty()) throw Failure(HAPTICD_REFUSED, refusal);
  if (has_ended) throw Failure(HAPTICD_ENDED, "hapticd was told to stop");
  throw Failure(HAPTICD_LOST, "hapticd is gone; it may come back under the same name");
}

}  // namespace haptic
