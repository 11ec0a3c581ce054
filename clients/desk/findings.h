// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "clients/desk/machine_facts.h"

namespace haptic {

enum class Grade {
  kGood,
  kHint,   // could be better; a session works
  kWrong,  // a session misses its deadlines, or does not reach its device
};

/// One thing that was looked at.
struct Finding {
  Grade grade = Grade::kGood;
  std::string subject{};  // "real-time priority"
  std::string fact{};     // what it is, and for a bad one what follows
  std::string mend{};     // empty: nothing to mend
};

/// Judges this machine, in a fixed order: one finding for each subject, and for each device one for
/// each of its subjects.
std::vector<Finding> findings_of(const MachineFacts& facts);

bool is_any_wrong(const std::vector<Finding>& findings);

/// For people, the mend below what it mends; and one array of objects.
void print_findings(const std::vector<Finding>& findings, std::ostream& out);
void print_findings_json(const std::vector<Finding>& findings, std::ostream& out);

}  // namespace haptic
