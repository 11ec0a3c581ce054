// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "clients/c/calls.h"
#include "clients/library/client.h"
#include "proto/wire/parts.h"

namespace haptic {

/// A ring of a session, with the record that was read last.
class Reader {
 public:
  explicit Reader(const std::string& session);
  virtual ~Reader() = default;

  /// True: there is a record to read. It is read ahead, and the present one stays.
  virtual bool has_more() noexcept = 0;
  /// Makes the next record the present one; false: there is none.
  virtual bool next() noexcept = 0;
  /// The newest one; false: the present one still is.
  virtual bool latest() noexcept = 0;
  virtual uint64_t lost() const noexcept = 0;
  /// The present record; null: none was read yet.
  virtual const std::byte* record() const noexcept = 0;

  bool is_connected() const { return attachments_.is_connected(); }
  /// Valid once it is not connected.
  bool is_refused() const { return !attachments_.refusal().empty(); }
  /// HAPTICD_OK, or throws a Failure that says why nothing comes.
  hapticd_result state();

 protected:
  Attachments attachments_;

 private:
  Source<ControlChannels> control_;
};

/// A kind of ring: its records, and a reader of it.
struct RingKind {
  std::string_view record;            // name
  size_t fixed;                       // bytes before its lists
  std::span<const RecordPart> parts;  // its lists
  std::unique_ptr<Reader> (*open)(const std::string& session, uint32_t hand, Start start);
};
/// By hapticd_ring; null: there is no such ring.
const RingKind* kind_of(uint32_t ring);

template <typename T>
inline constexpr hapticd_ring kRingOf = std::is_same_v<T, ServoFrame>   ? HAPTICD_SERVO
                                        : std::is_same_v<T, ContactSet> ? HAPTICD_CONTACT
                                        : std::is_same_v<T, SceneFrame> ? HAPTICD_SIM
                                                                        : HAPTICD_CONTROL;

}  // namespace haptic

struct hapticd_frames : haptic::Handle {
  std::string session;
  hapticd_ring ring{};
  uint32_t hand = 0;
  const haptic::RingKind* kind = nullptr;
  std::unique_ptr<haptic::Reader> reader;
  uint64_t lost_before = 0;  // by readers of hapticds that were killed

  /// The present record, where it is one of these; null: it is another, or none was read yet.
  template <typename T>
  const T* record() const noexcept {
    if (ring != haptic::kRingOf<T>) return nullptr;
    return reinterpret_cast<const T*>(reader->record());
  }
};
