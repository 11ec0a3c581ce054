// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/jitter_rows.h"
#include "proto/math/units.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

namespace haptic {
namespace {

/// A round in which every wake is this late, except for one of 300 µs.
JitterRound make_round(int64_t own_ns, int64_t peer_ns, int64_t hybrid_ns) {
  JitterRound round;
  for (int i = 0; i < 1000; ++i) {
    round.sleep.servo.late.add(own_ns);
    round.peer.late.add(peer_ns);
    round.hybrid.late.add(hybrid_ns);
  }
  round.sleep.servo.late_wakes = {{5000 * kUs, 300 * kUs}};
  round.sleep.witness.late_wakes = {{5030 * kUs, 270 * kUs}};
  round.sleep.servo.over_100us = 1;
  round.peer.over_100us = 2;
  return round;
}

Rows made_of(const std::vector<JitterRound>& rounds) {
  Rows rows;
  add_jitter_rows(rounds, rows);
  return rows;
}

Row find(const Rows& rows, const std::string& metric) {
  const auto row = std::find_if(rows.rows().begin(), rows.rows().end(),
                                [&](const Row& r) { return r.metric == metric; });
  REQUIRE(row != rows.rows().end());
  return *row;
}

bool has(const Rows& rows, const std::string& metric) {
  return std::any_of(rows.rows().begin(), rows.rows().end(),
                     [&](const Row& r) { return r.metric == metric; });
}

}  // namespace

TEST_CASE("jitter rows: the ratio is the median of the pairs' ratios, not of the sums") {
  // ratios 1, 1 and 4
  const Rows rows =
      made_of({make_round(100, 100, 10), make_round(200, 200, 10), make_round(160, 40, 10)});
  const Row p50 = find(rows, "wake p50 / cyclictest's, median of the pairs");
  CHECK(p50.value == Approx(1));
  CHECK(p50.goal == 1.25);
  CHECK(p50.holds == true);
  const Row own = find(rows, "wake p50, median of the pairs");
  CHECK(own.value == Approx(160e-9));
  CHECK(own.peer == "cyclictest");
  CHECK(own.peer_value.value() == Approx(100e-9));
  CHECK(find(rows, "wakes").value == 3000);
  CHECK(find(rows, "wakes later than 100 µs").peer_value == 6.0);
  CHECK(all_hold(rows.rows()));
}

TEST_CASE("jitter rows: a loop later than its goals misses them") {
  const Rows rows = made_of({make_round(130, 100, 1100), make_round(260, 100, 1100)});
  CHECK(find(rows, "wake p50 / cyclictest's, median of the pairs").holds == false);
  CHECK(find(rows, "wake p99 / cyclictest's, median of the pairs").holds == true);
  CHECK(find(rows, "hybrid: wake p99, median of the pairs").holds == false);
  CHECK(!all_hold(rows.rows()));
}

TEST_CASE("jitter rows: late wakes that the witness did not share are the loop's own") {
  std::vector<JitterRound> rounds{make_round(100, 100, 10), make_round(100, 100, 10)};
  CHECK(find(made_of(rounds), "share of them shared").holds == true);
  rounds[1].sleep.witness.late_wakes.clear();
  const Rows rows = made_of(rounds);
  CHECK(find(rows, "wakes later than 200 µs").value == 2);
  CHECK(find(rows, "share of them shared").value == Approx(0.5));
  CHECK(find(rows, "share of them shared").holds == false);
  CHECK(find(rows, "latest that was not shared").value == Approx(300e-6));
}

TEST_CASE("jitter rows: without rights nothing is judged, without a peer nothing is compared") {
  std::vector<JitterRound> rounds{make_round(900, 100, 5000)};
  rounds[0].sleep.servo.rights.fifo_errno = 1;
  CHECK(all_hold(made_of(rounds).rows()));
  rounds[0].sleep.servo.rights.fifo_errno = 0;
  rounds[0].peer = {};
  rounds[0].peer.problem = "no cyclictest";
  const Rows rows = made_of(rounds);
  CHECK(peer_problem_of(rounds) == "no cyclictest");
  CHECK(find(rows, "peer").note == "no cyclictest");
  CHECK(!find(rows, "wake p50, median of the pairs").peer_value.has_value());
  CHECK(!has(rows, "wake p50 / cyclictest's, median of the pairs"));
  // the hybrid needs no peer
  CHECK(find(rows, "hybrid: wake p99, median of the pairs").holds == false);
}

}  // namespace haptic
