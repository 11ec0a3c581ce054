// SPDX-License-Identifier: GPL-3.0-or-later
// The ring under every outcome of the C++ memory model: x86 alone would hide a missing order.
#include <catch2/catch.hpp>

#include "proto/ipc/ring.h"
#include "proto/ipc/ring_source.h"
#include "tests/proto/ipc/broken_ring.h"
#include "tests/proto/ipc/memory_model.h"
#include "tests/support/self_describing.h"

namespace haptic {
namespace {

using test::BrokenRing;
using test::Defect;
using test::MemoryModel;
using test::ModelAtomic;
constexpr uint64_t kSlots = 4;
using Fixed = test::SelfDescribing<2>;  // two words can be torn
// of two or three parts of at most one or two elements; twice the longest item fits, and on average
// three: slots are reused, and words under slots that are not
template <size_t kParts, size_t kMost = 1, size_t kWords = 1 + kParts*(1 + kMost)>
using Varying = PackedRing<test::VaryingRecord<kWords, kParts>, kSlots, 16 * kWords, ModelAtomic>;
template <typename RingType>
constexpr bool kIsPacked = requires {
  RingType::kWords;
};
constexpr uint64_t kLapped = kSlots + 3;  // items: three slots are overwritten
// read one after the other; with more of varying length there are too many outcomes to try
template <typename RingType>
constexpr uint64_t kMostInOrder = kIsPacked<RingType> ? kSlots + 1 : kLapped;

struct Findings {
  uint64_t outcomes = 0;
  uint64_t torn = 0;        // mixed items, or an item with the number of another
  uint64_t lost = 0;        // counted as published, not overwritten, but not delivered
  uint64_t miscounted = 0;  // delivered and lost do not add up to the reader's position
  uint64_t all() const { return torn + lost + miscounted; }
};

template <typename RingType>
void publish_items(RingType& ring, uint64_t count) {
  for (uint64_t n = 0; n < count; ++n) ring.publish(RingType::Item::make(n));
}

/// True if no item was overwritten.
template <typename RingType>
bool all_fit(uint64_t published) {
  return test::reach<RingType>(published - 1) == published - 1;
}

template <typename Item>
void check_item(const Item& out, uint64_t n, Findings& found) {
  found.torn += !out.is_whole() || out.n != n;
}

/// A reader in order, from the first item on.
template <typename RingType>
void read_in_order(const RingType& ring, uint64_t published, Findings& found) {
  Cursor cursor;
  uint64_t got = 0;
  for (typename RingType::Item out; read_next(ring, cursor, out); ++got)
    check_item(out, cursor.next - 1, found);
  found.miscounted += got + cursor.lost != cursor.next || cursor.next > published;
  if (all_fit<RingType>(published)) found.lost += cursor.lost;
}

/// Readers of a living writer of that many items, one after the other in each outcome.
template <typename RingType>
void look_beside_writer(uint64_t published, MemoryModel::Defect defect, Findings& found) {
  MemoryModel model(defect);
  RingType ring;
  publish_items(ring, published);
  if (published <= kMostInOrder<RingType>) {
    found.outcomes += model.explore(false, [&] {
      read_in_order(ring, published, found);
      return found.all() == 0;
    });
  }
  found.outcomes += model.explore(false, [&] {
    typename RingType::Item out;
    const uint64_t end = ring.published();
    const bool has_item = ring.latest(out);
    if (has_item) found.torn += !out.is_whole() || out.n + 1 < end;
    if (!has_item && all_fit<RingType>(published)) found.lost += end > 0;
    return found.all() == 0;
  });
  // by number, whether it is announced or not
  for (uint64_t n = 0; n < published; ++n) {
    found.outcomes += model.explore(false, [&] {
      if (typename RingType::Item out; ring.read(n, out)) check_item(out, n, found);
      return found.all() == 0;
    });
  }
}

/// A reader after a writer that was killed after each number of stores.
template <typename RingType>
void look_after_kill(uint64_t published, MemoryModel::Defect defect, Findings& found) {
  uint64_t stores = ~uint64_t{0};
  for (uint64_t killed_after = 0; killed_after <= stores; ++killed_after) {
    MemoryModel model(defect);
    RingType ring;
    model.kill_writer_after(killed_after);
    publish_items(ring, published);
    if (model.n_stores() < killed_after) stores = model.n_stores();
    found.outcomes += model.explore(true, [&] {
      const uint64_t end = ring.published();
      Cursor cursor;
      uint64_t got = 0, last = 0;
      for (typename RingType::Item out; read_final(ring, cursor, out); ++got) {
        check_item(out, cursor.next - 1, found);
        last = out.n;
      }
      found.miscounted += got + cursor.lost != end;
      // all except those in the place of the next item, which may be half written
      found.lost += got < test::reach<RingType>(end) || (got > 0 && last + 1 != end);
      return found.all() == 0;
    });
  }
}

template <typename RingType>
Findings look_at(MemoryModel::Defect defect = nullptr) {
  Findings found;
  for (const uint64_t published : {uint64_t{1}, uint64_t{3}, kSlots, kSlots + 1, kLapped}) {
    look_beside_writer<RingType>(published, defect, found);
  }
  look_after_kill<RingType>(kLapped, defect, found);
  return found;
}

template <Defect kDefect>
using ModelledBroken = BrokenRing<Fixed, kSlots, kDefect, ModelAtomic>;

}  // namespace

TEST_CASE("ring: no outcome the memory model allows is torn, loses an item or miscounts") {
  const Findings found = look_at<Ring<Fixed, kSlots, ModelAtomic>>();
  CAPTURE(found.outcomes);
  CHECK(found.torn == 0);
  CHECK(found.lost == 0);
  CHECK(found.miscounted == 0);
  CHECK(found.outcomes > 1000);
  // the copy without a defect behaves like the ring
  const Findings copied = look_at<ModelledBroken<Defect::kNone>>();
  CHECK(copied.outcomes == found.outcomes);
  CHECK(copied.all() == 0);
}

TEMPLATE_TEST_CASE_SIG("ring: each step and each memory order left out is found by the same look",
                       "", ((Defect kDefect), kDefect), Defect::kNoRecheck,
                       Defect::kOddTicketDropped, Defect::kHeadFirst, Defect::kRelaxedHead,
                       Defect::kRelaxedWords, Defect::kRelaxedTicket, Defect::kRelaxedCountLoad,
                       Defect::kRelaxedFirstLook, Defect::kRelaxedWordLoads) {
  CHECK(look_at<ModelledBroken<kDefect>>().all() > 0);
}

TEMPLATE_TEST_CASE_SIG("ring: no outcome tears or loses an item of varying length", "",
                       ((size_t kParts, size_t kMost), kParts, kMost), (2, 1), (3, 1), (2, 2)) {
  const Findings found = look_at<Varying<kParts, kMost>>();
  CAPTURE(found.outcomes);
  CHECK(found.torn == 0);
  CHECK(found.lost == 0);
  CHECK(found.miscounted == 0);
  CHECK(found.outcomes > 1000);
}

TEST_CASE("ring: with items of varying length each order left out is found as well") {
  using Change = MemoryModel::Change;
  // in the order of the ring's members: count, oldest, end; ticket, begin and words of each slot
  enum Word : size_t { kCount, kOldest, kEnd, kTicket, kBegin, kWords, kWord };
  static const auto word_at = [](size_t location) {
    if (location < kTicket) return location;
    return location < kTicket + 3 * kSlots ? kTicket + (location - kTicket) % 3 : size_t{kWord};
  };
  static Word weakened;
  static bool in_store;
  for (const Word word : {kCount, kTicket, kBegin, kWord}) {
    for (const bool store : {false, true}) {
      weakened = word, in_store = store;
      CAPTURE(word, store);
      CHECK(look_at<Varying<2>>([](size_t location, bool is_store, uint64_t) {
              const bool is_it = word_at(location) == weakened && is_store == in_store;
              return is_it ? Change::kRelaxed : Change::kNone;
            }).all() > 0);
    }
  }
  // items that are not taken back before they are overwritten
  CHECK(look_at<Varying<2>>([](size_t location, bool is_store, uint64_t value) {
          const bool is_it = word_at(location) == kTicket && is_store && value == 0;
          return is_it ? Change::kDropped : Change::kNone;
        }).all() > 0);
}

}  // namespace haptic
