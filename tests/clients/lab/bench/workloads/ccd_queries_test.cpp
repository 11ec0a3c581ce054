// SPDX-License-Identifier: GPL-3.0-or-later
// The elementary queries of continuous collision detection against exact ground truth and another
// method.
#include "clients/lab/bench/workloads/ccd_queries.h"

#include <catch2/catch.hpp>
#include <fstream>

#include "clients/lab/bench/reference/redon_intervals.h"
#include "tests/support/data.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"

using namespace haptic;
using namespace haptic::test;

TEST_CASE("ccd queries: no false negative on exact ground truth, few false alarms", "[trap]") {
  size_t n = 0, truly = 0, missed = 0, false_alarms = 0;
  for (const CcdFile& file : read_ccd_queries(data_file("ccd-queries"))) {
    for (const CcdQuery& query : file.queries) {
      const bool hit = meeting_of(query, 1e-6).has_value();
      ++n;
      truly += query.meets ? 1 : 0;
      missed += query.meets && !hit ? 1 : 0;
      false_alarms += !query.meets && hit ? 1 : 0;
    }
  }
  CAPTURE(n, truly, false_alarms);
  CHECK(n >= 400);
  CHECK(truly == 288);
  CHECK(missed == 0);
  // every approach within the tolerance counts as a hit
  CHECK(false_alarms <= 70);
}

TEST_CASE("ccd queries: what intervals in time say, on queries of a hand's scale") {
  size_t meet = 0, differ = 0;
  const std::vector<CcdQuery> queries = hand_scale_queries(trials(4000));
  for (const CcdQuery& query : queries) {
    const auto own = meeting_of(query, 1e-9);
    const auto other = meeting_by_intervals(query, 1e-9, 20'000);
    meet += own ? 1 : 0;
    differ += own.has_value() != other.has_value() ? 1 : 0;
    // both are lower bounds of the same time, ours within the tolerance
    if (own && other) CHECK(own->time == Approx(*other).margin(2e-3));
  }
  CHECK(meet > queries.size() / 50);
  // neither misses a hit: where they differ, one has a false alarm
  CHECK(differ <= queries.size() / 500);
}

TEST_CASE("ccd queries: rows that are no queries are named") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() + "/scene/edge-edge");
  std::ofstream(folder.path() + "/scene/edge-edge/bad.csv") << "1,2,3\n";
  CHECK_THROWS_WITH(read_ccd_queries(folder.path()), Catch::Contains("line 1"));
  CHECK(read_ccd_queries(folder.path() + "/nowhere").empty());
}
