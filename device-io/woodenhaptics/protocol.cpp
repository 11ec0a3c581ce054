// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/woodenhaptics/protocol.h"

#include <charconv>
#include <system_error>

#include "proto/math/assert.h"

namespace haptic {
namespace {

/// Parses exactly N integers separated by commas.
template <size_t N>
bool parse_numbers(const char* at, const char* end, std::array<int32_t, N>& numbers) {
  for (size_t i = 0; i < N; ++i) {
    if (i > 0 && (at == end || *at++ != ',')) return false;
    const auto [next, error] = std::from_chars(at, end, numbers[i]);
    if (error != std::errc()) return false;
    at = next;
  }
  return at == end;
}

}  // namespace

CommandText encode_currents(const Milliamperes& currents, Challenge before, size_t motors) {
  HAPTIC_ASSERT(motors > 0 && motors <= currents.size());
  CommandText command;
  char* at = command.text.data();
  char* const end = at + command.text.size();
  if (before == Challenge::kNotAsMany) *at++ = '[';
  if (before != Challenge::kNone) {
    *at++ = ']';
    *at++ = '\n';
  }
  *at++ = '[';
  for (size_t i = 0; i < motors; ++i) {
    if (i > 0) *at++ = ',';
    at = std::to_chars(at, end, currents[i]).ptr;
  }
  *at++ = ']';
  *at++ = '\n';
  HAPTIC_ASSERT(at <= end);
  command.size = static_cast<size_t>(at - command.text.data());
  return command;
}

bool ReplyReader::push(char byte, EncoderReply& reply) noexcept {
  if (byte == '[') {
    // a line cut off by the next one
    if (inside_) ++rejected_;
    inside_ = true;
    size_ = 0;
    return false;
  }
  if (!inside_) return false;
  if (byte != ']') {
    if (size_ < text_.size()) {
      text_[size_++] = byte;
    } else {
      inside_ = false;
      ++rejected_;
    }
    return false;
  }
  inside_ = false;
  std::array<int32_t, 8> numbers;
  if (!parse_numbers(text_.data(), text_.data() + size_, numbers)) {
    ++rejected_;
    return false;
  }
  reply.model = numbers[0];
  for (size_t i = 0; i < reply.counts.size(); ++i) reply.counts[i] = numbers[i + 1];
  reply.error = numbers[7];
  return true;
}

}  // namespace haptic
