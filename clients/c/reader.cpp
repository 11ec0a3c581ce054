// SPDX-License-Identifier: Apache-2.0
#include "clients/c/reader.h"

#include <array>

#include "proto/ipc/sessions.h"

namespace haptic {
namespace {

constexpr int64_t kPatienceNs = 500'000'000;  // until the first segment comes
constexpr int64_t kLookNs = 250'000;          // between two looks for it

template <auto kMember>
class ReaderOf final : public Reader {
  using Item = typename RingSource<kMember>::Item;

 public:
  ReaderOf(const std::string& session, uint32_t hand, Start start)
      : Reader(session), ring_(attachments_.ring<kMember>(start, hand)) {
    attachments_.start();
    // a ring counts from where it is found
    for (const int64_t end_ns = now_ns() + kPatienceNs; now_ns() < end_ns;) {
      if (has_more() || ring_.header() != nullptr || !is_connected()) break;
      sleep_until(now_ns() + kLookNs);
    }
  }

  bool has_more() noexcept override { return is_ahead_ = is_ahead_ || ring_.next(*ahead_); }
  bool next() noexcept override { return has_more() && step(); }
  bool latest() noexcept override {
    is_ahead_ = ring_.latest(*ahead_) || is_ahead_;
    return is_ahead_ && step();
  }
  uint64_t lost() const noexcept override { return ring_.lost(); }
  const std::byte* record() const noexcept override {
    return any_ ? reinterpret_cast<const std::byte*>(present_.get()) : nullptr;
  }

 private:
  bool step() noexcept {
    present_.swap(ahead_);
    is_ahead_ = false;
    return any_ = true;
  }

  RingSource<kMember> ring_;
  std::unique_ptr<Item> present_ = std::make_unique<Item>(), ahead_ = std::make_unique<Item>();
  bool any_ = false, is_ahead_ = false;
};

template <auto kMember>
std::unique_ptr<Reader> open_ring(const std::string& session, uint32_t hand, Start start) {
  return std::make_unique<ReaderOf<kMember>>(session, hand, start);
}

template <auto kMember>
RingKind kind(std::string_view record) {
  using Item = typename RingSource<kMember>::Item;
  const std::span<const RecordPart> parts = kParts<Item>;
  return {record, parts.empty() ? sizeof(Item) : parts[0].offset, parts, &open_ring<kMember>};
}

}  // namespace

Reader::Reader(const std::string& session)
    : attachments_(connect_session(session)), control_(attachments_.source<ControlChannels>()) {}

hapticd_result Reader::state() {
  const bool connected = is_connected();
  if (!connected) control_.channels();
  return say_gone(connected, attachments_.refusal(), !connected && has_ended(control_.header()));
}

const RingKind* kind_of(uint32_t ring) {
  // in the order of hapticd_ring
  static const std::array kKinds{
      kind<&ServoChannels::frames>("ServoFrame"), kind<&ContactChannels::sets>("ContactSet"),
      kind<&SimChannels::frames>("SceneFrame"), kind<&ControlChannels::frames>("ControlFrame")};
  return ring < kKinds.size() ? &kKinds[ring] : nullptr;
}

}  // namespace haptic
