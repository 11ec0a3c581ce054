// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "clients/report/report.h"

namespace haptic {

/// Selects the rows of a short report, which fits 80 columns: those with a goal, and a few more.
std::vector<Row> brief(const std::vector<Row>& rows);

/// The last line of a run: passed or FAILED, what was shown, what to do next. `shown` is what the
/// hand touched, "the Stanford bunny"; `trouble` why the run failed whatever its rows say.
std::string verdict(const std::vector<Row>& rows, const std::string& shown, double seconds,
                    const std::string& trouble, const std::string& next);

}  // namespace haptic
