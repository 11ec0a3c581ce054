// SPDX-License-Identifier: GPL-3.0-or-later
// A suite that measures nothing; outside.cmake makes a bench of it too.
#include "clients/lab/support/measurement.h"

namespace haptic {

Measured suite_outside(Command&) {
  return [](Report& report) { report.rows.add("figures", 0); };
}

}  // namespace haptic
