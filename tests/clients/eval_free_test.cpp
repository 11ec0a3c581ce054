// SPDX-License-Identifier: GPL-3.0-or-later
// The judge of free space, and what it says of every renderer.
#include "clients/eval_free.h"

#include <catch2/catch.hpp>

#include "tests/support/torture_scale.h"

using namespace haptic;
using namespace haptic::test;

TEST_CASE("eval free: no renderer without mass is felt where nothing is", "[lab]") {
  FreeEval eval;
  eval.ticks = 150;
  eval.ages = {1, 2, 7, 20};
  eval.all_scenes = false;
  for (const Row& row : eval_free(eval)) {
    CAPTURE(row.case_name, row.metric, row.value, row.note);
    CHECK(row.holds.value_or(true));
  }
}
