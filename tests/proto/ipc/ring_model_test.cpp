// SPDX-License-Identifier: GPL-3.0-or-later
// The ring under every outcome of the C++ memory model: x86 alone would hide a missing order.
#include <catch2/catch.hpp>

#include "proto/ipc/handout.h"
#include "proto/ipc/ring.h"
#include "tests/proto/ipc/broken_ring.h"
#include "tests/proto/ipc/memory_model.h"
#include "tests/support/self_describing.h"

namespace haptic {
namespace {

using test::BrokenRing;
using test::Defect;
using test::MemoryModel;
using test::ModelAtomic;
using Item = test::SelfDescribing<2>;  // two words can be torn
constexpr uint64_t kSlots = 4;
constexpr uint64_t kLapped = kSlots + 3;  // items: three slots are overwritten

struct Findings {
  uint64_t outcomes = 0;
  uint64_t torn = 0;        // mixed items, or an item with the number of another
  uint64_t lost = 0;        // counted as published, not overwritten, but not delivered
  uint64_t miscounted = 0;  // delivered and lost do not add up to the reader's position
  uint64_t all() const { return torn + lost + miscounted; }
};

template <typename RingType>
void publish_items(RingType& ring, uint64_t count) {
  for (uint64_t n = 0; n < count; ++n) ring.publish(Item::make(n));
}

void check_item(const Item& out, uint64_t n, Findings& found) {
  found.torn += !out.is_whole() || out.n != n;
}

/// A reader in order, from the first item on.
template <typename RingType>
void read_in_order(const RingType& ring, uint64_t published, Findings& found) {
  Cursor cursor;
  uint64_t got = 0;
  for (Item out; read_next(ring, cursor, out); ++got) check_item(out, cursor.next - 1, found);
  found.miscounted += got + cursor.lost != cursor.next || cursor.next > published;
  // without wrap-around there is nothing to lose
  if (published <= kSlots) found.lost += cursor.lost;
}

/// Readers of a living writer of that many items, one after the other in each outcome.
template <typename RingType>
void look_beside_writer(uint64_t published, Findings& found) {
  MemoryModel model;
  RingType ring;
  publish_items(ring, published);
  found.outcomes += model.explore(false, [&] {
    read_in_order(ring, published, found);
    return found.all() == 0;
  });
  found.outcomes += model.explore(false, [&] {
    Item out;
    const uint64_t end = ring.published();
    const bool has_item = ring.latest(out);
    if (has_item) found.torn += !out.is_whole() || out.n + 1 < end;
    if (!has_item && published <= kSlots) found.lost += end > 0;
    return found.all() == 0;
  });
  // by number, whether it is announced or not
  for (uint64_t n = 0; n < published; ++n) {
    found.outcomes += model.explore(false, [&] {
      if (Item out; ring.read(n, out)) check_item(out, n, found);
      return found.all() == 0;
    });
  }
}

/// A reader after a writer that was killed after each number of stores.
template <typename RingType>
void look_after_kill(uint64_t published, Findings& found) {
  uint64_t stores = ~uint64_t{0};
  for (uint64_t killed_after = 0; killed_after <= stores; ++killed_after) {
    MemoryModel model;
    RingType ring;
    model.kill_writer_after(killed_after);
    publish_items(ring, published);
    if (model.n_stores() < killed_after) stores = model.n_stores();
    found.outcomes += model.explore(true, [&] {
      const uint64_t end = ring.published();
      Cursor cursor;
      uint64_t got = 0, last = 0;
      for (Item out; read_final(ring, cursor, out); ++got) {
        check_item(out, cursor.next - 1, found);
        last = out.n;
      }
      found.miscounted += got + cursor.lost != end;
      // all except the oldest, whose slot may be half overwritten
      const uint64_t reach = end < kSlots ? end : kSlots - 1;
      found.lost += got < reach || (got > 0 && last + 1 != end);
      return found.all() == 0;
    });
  }
}

template <typename RingType>
Findings look_at() {
  Findings found;
  for (const uint64_t published : {uint64_t{1}, uint64_t{3}, kSlots, kSlots + 1, kLapped}) {
    look_beside_writer<RingType>(published, found);
  }
  look_after_kill<RingType>(kLapped, found);
  return found;
}

template <Defect kDefect>
using ModelledBroken = BrokenRing<Item, kSlots, kDefect, ModelAtomic>;

}  // namespace

TEST_CASE("ring: no outcome the memory model allows is torn, loses an item or miscounts") {
  const Findings found = look_at<Ring<Item, kSlots, ModelAtomic>>();
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

}  // namespace haptic
