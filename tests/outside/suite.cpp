// SPDX-License-Identifier: GPL-3.0-or-later
// A suite that measures nothing.
#include "clients/lab/support/measurement.h"

namespace haptic {

Measured suite_outside(Command&) {
  return [] {
    Row row;
    row.case_name = "outside";
    row.metric = "figures";
    return Report(std::vector<Row>{row});
  };
}

}  // namespace haptic
