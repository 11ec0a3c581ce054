// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <boost/interprocess/mapped_region.hpp>
#include <cstddef>
#include <cstdint>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

#include "proto/ipc/channels.h"
#include "proto/os/file_descriptor.h"
#include "proto/os/message.h"
#include "proto/os/realtime.h"
#include "proto/wire/parts.h"
#include "proto/wire/schema.h"

/// A segment: one writer's rings in one memfd, sealed so that nobody else can write or resize it.
/// Its header holds a hash of the layout of the contents, which a reader checks before use.
namespace haptic {

inline constexpr uint64_t kSegmentMagic = 0x3147'4553'5450'4148;  // "HAPTSEG1", little endian

enum class SegmentState : uint32_t { kInit = 0, kRun = 1, kDrain = 2, kDead = 3 };

/// First bytes of a segment. Written once and published by `magic`, except the heartbeat line,
/// which the writer updates. All members are atomic: each is read once and checked.
struct SegmentHeader {
  using U64 = std::atomic<uint64_t>;
  using U32 = std::atomic<uint32_t>;

  alignas(128) U64 magic;  // stored last
  U32 abi_major;
  U32 abi_minor;
  U64 layout_hash;
  U64 total_bytes;
  U32 segment_id;
  U64 generation;  // one higher for each restart of the writer
  U64 pid;
  U64 process_start;  // start_time_of(pid): reveals a reused pid
  U64 clock_id;       // of every t_ns in the segment

  // own cache line: written once a cycle, never together with the lines above
  alignas(128) U64 heartbeat;         // cycles since start
  std::atomic<int64_t> heartbeat_ns;  // CLOCK_MONOTONIC of the last one
  U32 state;                          // SegmentState
  U32 realtime_bits;                  // RealtimeBit
  std::atomic<int32_t> fifo_errno;    // why SCHED_FIFO was refused; 0: it was not
  std::atomic<int32_t> memory_errno;  // why locked memory was; 0: it was not

  // zero; a client of an older version, which had a table here, finds the file long enough to read
  // that its layout is another
  alignas(128) std::array<U64, 48> reserved;
};
static_assert(std::is_standard_layout_v<SegmentHeader> && sizeof(SegmentHeader) == 640);
static_assert(SegmentHeader::U64::is_always_lock_free && SegmentHeader::U32::is_always_lock_free);

/// The rights its writer was granted and refused.
RealtimeReport realtime_of(const SegmentHeader& header) noexcept;

/// Why a segment was not accepted.
enum class SegmentFault {
  kSystem,     // the kernel refused; errno in the message
  kNotSealed,  // could be truncated under the reader
  kTooShort,   // smaller than its header or than it claims
  kNotReady,   // no magic number before the deadline
  kWrongMagic,
  kWrongAbi,     // written by another version of the program
  kWrongLayout,  // same version, other structs
  kWrongKind,    // another process's segment
  kTooLong,      // a sealed file larger than what is read
};

struct SegmentError : MessageError {
  SegmentError(SegmentFault why, const std::string& what) : MessageError(what), fault(why) {}
  SegmentFault fault;
};

/// FNV-1a, 64 bit (Fowler, Noll, Vo), of text and of a number as eight bytes.
constexpr uint64_t fnv1a(std::string_view text, uint64_t hash = 0xcbf2'9ce4'8422'2325) {
  for (const char c : text) {
    hash = (hash ^ static_cast<uint8_t>(c)) * 0x0000'0100'0000'01b3;
  }
  return hash;
}
constexpr uint64_t fnv1a(uint64_t value, uint64_t hash) {
  for (int i = 0; i < 8; ++i) {
    hash = (hash ^ ((value >> (8 * i)) & 0xff)) * 0x0000'0100'0000'01b3;
  }
  return hash;
}

/// Identity of a record type: size, alignment, parts and, if it has one, its schema.
template <typename T>
constexpr uint64_t record_hash() {
  uint64_t hash = fnv1a(alignof(T), fnv1a(uint64_t{sizeof(T)}, fnv1a("")));
  for (const RecordPart& part : kParts<T>) {
    for (const uint64_t number : {part.offset, part.element, part.most}) {
      hash = fnv1a(number, hash);
    }
  }
  if constexpr (requires { Schema<T>::text; }) {
    hash = fnv1a(Schema<T>::name, hash);
    // of all records: one may be nested in another
#define RECORD(record, ...) hash = fnv1a(Schema<record>::text, hash);
#define FIELD(...)
#define ARRAY(...)
#define PART(...)
#define END(...)
#include "proto/wire/records.def"
  }
  return hash;
}

/// A segment as it lies in memory. Channels::Rings is a tuple of its rings in their order.
template <typename Channels>
struct SegmentLayout {
  static_assert(std::is_standard_layout_v<Channels>);
  SegmentHeader header;
  Channels channels;
};

namespace detail {
/// Identity of a ring: its size, its slots and its items.
template <typename RingType>
constexpr uint64_t ring_hash(uint64_t hash) {
  hash = fnv1a(RingType::kCapacity, fnv1a(uint64_t{sizeof(RingType)}, hash));
  return fnv1a(record_hash<typename RingType::Item>(), hash);
}

/// Identity of the rings of a channel struct, in the order of their places.
template <typename Channels, typename... Rings>
constexpr uint64_t layout_hash(std::type_identity<std::tuple<Rings...>>) {
  static_assert((sizeof(Rings) + ...) == sizeof(Channels), "Channels::Rings lists every ring");
  uint64_t hash = fnv1a(uint64_t{sizeof(SegmentLayout<Channels>)}, fnv1a(Channels::kName));
  ((hash = ring_hash<Rings>(hash)), ...);
  return hash;
}
}  // namespace detail

/// The properties that a reader requires of a segment before it uses a ring.
struct SegmentSpec {
  SegmentId id;
  const char* name;
  size_t total_bytes;
  uint64_t layout_hash;
};

/// Required layout of a segment of these channels, known at compile time.
template <typename Channels>
inline constexpr SegmentSpec kSegmentSpec{
    Channels::kId, Channels::kName, sizeof(SegmentLayout<Channels>),
    detail::layout_hash<Channels>(std::type_identity<typename Channels::Rings>{})};

/// Required layout of the segment of this hand; of what no hand has, of the session's.
template <typename Channels>
constexpr SegmentSpec segment_spec(uint32_t hand) {
  SegmentSpec spec = kSegmentSpec<Channels>;
  if constexpr (requires { Channels::id(hand); }) {
    spec.id = Channels::id(hand);
    spec.name = Channels::name(hand);
  }
  return spec;
}

/// Opens the file of `fd` again, read-only, for readers. Throws SegmentError.
FileDescriptor reopen_read_only(int fd);

/// A memfd with these bytes, sealed against any change; hands the session's configuration to the
/// children. Throws SegmentError.
FileDescriptor make_sealed_file(const char* name, std::span<const std::byte> bytes);

/// Memory of a writer: created, sized, mapped; sealed by publish().
class WritableSegment {
 public:
  WritableSegment(const SegmentSpec& spec, uint64_t generation);

  /// Stores the magic number, then adds the last seals: from now on there can be no second writer.
  void publish();

  void* memory() const { return region_.get_address(); }
  SegmentHeader& header() const { return *static_cast<SegmentHeader*>(memory()); }
  int fd() const { return fd_.get(); }

 private:
  FileDescriptor fd_;
  boost::interprocess::mapped_region region_;
};

/// The segment a process publishes into. The constructor allocates, maps and touches all its
/// memory; after that no call fails, allocates or enters the kernel. Throws SegmentError.
template <typename Channels>
class SegmentWriter {
 public:
  explicit SegmentWriter(uint64_t generation, uint32_t hand = kFirstHand)
      : memory_(segment_spec<Channels>(hand), generation) {
    char* base = static_cast<char*>(memory_.memory());
    channels_ = new (base + offsetof(SegmentLayout<Channels>, channels)) Channels;
    memory_.publish();
  }

  Channels& channels() noexcept { return *channels_; }
  int fd() const noexcept { return memory_.fd(); }
  const SegmentHeader& header() const noexcept { return memory_.header(); }

  /// Once per cycle: heartbeat for the watchdog.
  void beat(uint64_t cycle, int64_t t_ns) noexcept {
    memory_.header().heartbeat_ns.store(t_ns, std::memory_order_relaxed);
    memory_.header().heartbeat.store(cycle, std::memory_order_release);
  }

  void set_state(SegmentState state) noexcept {
    memory_.header().state.store(static_cast<uint32_t>(state), std::memory_order_release);
  }

  void set_realtime(const RealtimeReport& report) noexcept {
    memory_.header().fifo_errno.store(report.fifo_errno, std::memory_order_relaxed);
    memory_.header().memory_errno.store(report.memory_errno, std::memory_order_relaxed);
    memory_.header().realtime_bits.store(report.bits, std::memory_order_release);
  }

 private:
  WritableSegment memory_;
  Channels* channels_;
};

struct ViewOptions {
  int64_t ready_timeout_ns = 0;  // longest wait for the magic number
  bool lock_memory = false;      // mlock it; a refusal is no error
  bool populate = true;          // map all pages at once
};

/// A checked, read-only, prefaulted mapping of a segment.
class SegmentMapping {
 public:
  /// Takes the descriptor. Throws SegmentError with the fault and one line of text.
  SegmentMapping(FileDescriptor fd, const SegmentSpec& spec, const ViewOptions& options = {});

  const SegmentHeader& header() const { return *static_cast<const SegmentHeader*>(memory()); }
  const void* memory() const { return region_.get_address(); }
  uint64_t generation() const noexcept { return generation_; }

  /// The rings, if the segment was checked against kSegmentSpec<Channels>.
  template <typename Channels>
  const Channels& channels() const noexcept {
    const char* base = static_cast<const char*>(memory());
    return *std::launder(
        reinterpret_cast<const Channels*>(base + offsetof(SegmentLayout<Channels>, channels)));
  }

 private:
  boost::interprocess::mapped_region region_;
  uint64_t generation_ = 0;
};

/// SegmentMapping of known channels.
template <typename Channels>
class SegmentView : public SegmentMapping {
 public:
  explicit SegmentView(FileDescriptor fd, const ViewOptions& options = {})
      : SegmentMapping(std::move(fd), kSegmentSpec<Channels>, options) {}

  const Channels& channels() const noexcept { return SegmentMapping::channels<Channels>(); }
};

}  // namespace haptic
