// SPDX-License-Identifier: GPL-3.0-or-later
// The ring between processes. Short in CI; HAPTIC_TORTURE_SCALE=400 gives 10^9 reads, 100 gives
// 1,000 kills per record size: docs/benchmarks/README.md.
#include "tests/process/ring_torture.h"

#include <catch2/catch.hpp>
#include <cstdio>

#include "tests/process/flat_out_torture.h"
#include "tests/process/kill_torture.h"
#include "tests/proto/ipc/broken_ring.h"
#include "tests/support/self_describing.h"
#include "tests/support/torture_scale.h"

namespace haptic {
namespace {

using namespace test;
template <size_t kBytes>
using Record = test::SelfDescribing<kBytes / 8>;
/// With records of varying length the words are overwritten before the slots are used up.
template <size_t kBytes, bool kVaries, uint64_t kSlots>
using RingOf =
    std::conditional_t<kVaries,
                       PackedRing<test::VaryingRecord<kBytes / 8>, kSlots, kBytes * kSlots / 4>,
                       Ring<Record<kBytes>, kSlots>>;

// short rings: the writer is always close behind the readers
constexpr uint64_t kFlatOutSlots = 32;
constexpr uint64_t kKillSlots = 16;
constexpr int64_t kSecond = kNsPerSecond;

/// Reads at scale 1; 2.5 · 10^6 over the four sizes.
uint64_t wanted_reads(size_t bytes) {
  const double reads = bytes <= 64 ? 1.5e6 : bytes <= 256 ? 0.75e6 : bytes <= 1024 ? 0.2e6 : 0.05e6;
  return static_cast<uint64_t>(reads * test::torture_scale() * (test::kSlowdown > 1 ? 0.02 : 1));
}

unsigned long long number(uint64_t value) {
  return value;
}

void print_flat_out(size_t bytes, const FlatOutFindings& f, double seconds) {
  std::printf(
      "flat out,%zu B: %.1f s, %llu published, %llu read, %llu lost, %llu torn, %llu disorder, "
      "%llu vanished, %llu miscounted, %llu stops, %llu reader kills\n",
      bytes, seconds, number(f.published), number(f.reads), number(f.lost), number(f.torn),
      number(f.disorder), number(f.vanished), number(f.miscounted), number(f.stops),
      number(f.kills));
  std::fflush(stdout);  // a forked child must not print the buffer again
}

void print_kills(size_t bytes, const KillFindings& f, double seconds) {
  std::printf(
      "kill -9,%zu B: %.1f s, %llu kills, %llu begun and not counted, %llu published, %llu read, "
      "%llu lost, "
      "%llu unreadable, %llu torn, %llu disorder, %llu miscounted of %llu balances, %llu stops, "
      "%llu reader kills, seed %llu\n",
      bytes, seconds, number(f.kills), number(f.in_mid_copy), number(f.published), number(f.reads),
      number(f.lost), number(f.unreadable), number(f.torn), number(f.disorder),
      number(f.miscounted), number(f.balances), number(f.reader_stops), number(f.reader_kills),
      number(f.seed));
}

double seconds_since(int64_t start_ns) {
  return 1e-9 * static_cast<double>(now_ns() - start_ns);
}

/// Kills in batches until something is found or the time is over.
template <typename RingType>
uint64_t faults_after_kills() {
  const int64_t give_up = now_ns() + 60 * kSecond;
  uint64_t faults = 0;
  while (faults == 0 && now_ns() < give_up) faults = KillTorture<RingType>().run(10).faults();
  return faults;
}

template <Defect kDefect>
uint64_t faults_flat_out() {
  using Broken = BrokenRing<Record<1024>, kFlatOutSlots, kDefect>;
  return FlatOutTorture<Broken>().run(~uint64_t{0}, 60 * kSecond, true).faults();
}

}  // namespace

TEMPLATE_TEST_CASE_SIG("ring torture: eight readers beside a writer that never pauses", "[torture]",
                       ((size_t kBytes, bool kVaries), kBytes, kVaries), (64, false), (256, false),
                       (1024, false), (8192, false), (1024, true)) {
  const int64_t start_ns = now_ns();
  const int64_t patience =
      static_cast<int64_t>(120 * std::max(1.0, test::torture_scale())) * kSecond;
  const uint64_t wanted = wanted_reads(kBytes);
  const FlatOutFindings found =
      FlatOutTorture<RingOf<kBytes, kVaries, kFlatOutSlots>>().run(wanted, patience);
  print_flat_out(kBytes, found, seconds_since(start_ns));
  CHECK(found.torn == 0);
  CHECK(found.disorder == 0);
  CHECK(found.vanished == 0);
  CHECK(found.miscounted == 0);
  CHECK(found.crashes == 0);
  // the load was as intended
  CHECK(found.reads >= wanted);
  CHECK(found.lost > 0);
  CHECK(found.stops > 0);
  CHECK(found.kills > 0);
}

TEMPLATE_TEST_CASE_SIG("ring torture: writers killed at random points, generation after generation",
                       "[torture]", ((size_t kBytes, bool kVaries), kBytes, kVaries), (64, false),
                       (256, false), (1024, false), (8192, false), (1024, true)) {
  const int64_t start_ns = now_ns();
  const auto kills = static_cast<uint64_t>(10 * std::max(1.0, test::torture_scale()));
  const KillFindings found = KillTorture<RingOf<kBytes, kVaries, kKillSlots>>().run(kills);
  print_kills(kBytes, found, seconds_since(start_ns));
  CHECK(found.kills == kills);
  CHECK(found.unreadable == 0);
  CHECK(found.torn == 0);
  CHECK(found.disorder == 0);
  CHECK(found.miscounted == 0);
  CHECK(found.balances == 4);
  CHECK(found.crashes == 0);
  CHECK(found.reads > kills);
}

TEST_CASE(
    "ring torture: a ring without its re-check, or its odd ticket, or with its head first is "
    "caught beside a writer that never pauses") {
  CHECK(faults_flat_out<Defect::kNoRecheck>() > 0);
  CHECK(faults_flat_out<Defect::kOddTicketDropped>() > 0);
  CHECK(faults_flat_out<Defect::kHeadFirst>() > 0);
}

TEST_CASE("ring torture: a ring without its odd ticket or with its head first is caught by kills") {
  CHECK(faults_after_kills<BrokenRing<Record<1024>, kKillSlots, Defect::kOddTicketDropped>>() > 0);
  CHECK(faults_after_kills<BrokenRing<Record<1024>, kKillSlots, Defect::kHeadFirst>>() > 0);
}

}  // namespace haptic
