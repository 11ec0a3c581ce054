// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/wake_lateness.h"

#include <catch2/catch.hpp>
#include <sstream>

#include "clients/lab/support/cyclictest.h"
#include "proto/math/units.h"

namespace haptic {
TEST_CASE("wake lateness: a late wake is shared where the witness was held up at that time") {
  // wakes of the servo at 0, 1, 2, 3 and 4 ms; the last is not late enough to count
  const std::vector<LateWake> servo{{0, 300 * kUs},
                                    {1000 * kUs, 250 * kUs},
                                    {2000 * kUs, 900 * kUs},
                                    {3000 * kUs, 201 * kUs},
                                    {4000 * kUs, 200 * kUs}};
  const std::vector<LateWake> witness{{30 * kUs, 270 * kUs},     // the same delay
                                      {1260 * kUs, 500 * kUs},   // after the second was over
                                      {2790 * kUs, 105 * kUs},   // overlaps the third
                                      {3030 * kUs, 100 * kUs}};  // not late
  const SharedLateness shared = compare_with_witness(servo, witness);
  CHECK(shared.late == 4);
  CHECK(shared.shared == 2);
  CHECK(shared.largest_private_ns == 250 * kUs);
  CHECK(compare_with_witness(servo, {}).shared == 0);
  CHECK(compare_with_witness({}, witness).late == 0);
}

TEST_CASE("wake lateness: a loop and its witness tick on the same grid, 30 us apart") {
  const WakeOptions options{.seconds = 0.3};
  const WitnessedRun run = measure_witnessed_wakes(options);
  CHECK((run.witness.start_ns - run.servo.start_ns) % options.period == kWitnessPhaseNs);
  for (const WakeRun* r : {&run.servo, &run.witness}) {
    CAPTURE(r->late.count(), r->skipped, r->rights.explain());
    // every grid point is a tick or was skipped, except those skipped at the very end
    CHECK(r->late.count() + r->skipped <= 300);
    CHECK(r->late.count() >= 1);
    CHECK(r->over_1ms <= r->over_100us);
    CHECK(r->late_wakes.size() == r->over_100us);
  }
}

TEST_CASE("wake lateness: what cyclictest prints is read to the nanosecond") {
  std::istringstream output(
      "# /dev/cpu_dma_latency set to 0us\n"
      "# Histogram\n"
      "000000 000000\n"
      "004200 000090\n"
      "100000 000004\n"
      "100001 000003\n"
      "# Total: 000097\n"
      "# Min Latencies: 04200\n"
      "# Histogram Overflows: 00003\n"
      "# Thread 0: 00017 00311\n");
  const CyclictestRun run = parse_cyclictest(output);
  CHECK(run.problem.empty());
  CHECK(run.late.count() == 100);
  CHECK(run.over_100us == 6);
  CHECK(run.over_1ms == 3);
  CHECK(run.late.percentile(50) >= 4200);
  CHECK(run.late.percentile(50) <= 4233);
  CHECK(run.late.percentile(99) > 1'000'000);
}

TEST_CASE("wake lateness: without figures there is one line that says what to do") {
  std::istringstream nothing("sh: 1: cyclictest: not found\n");
  const CyclictestRun run = parse_cyclictest(nothing);
  CHECK(run.late.count() == 0);
  CHECK_THAT(run.problem, Catch::Contains("./run bench"));
  CHECK(run.problem.find('\n') == std::string::npos);
}

}  // namespace haptic
