// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

#include "clients/desk/trial/trial_step.h"

namespace haptic {

/// A step of a trial as it went.
struct TriedStep {
  std::string name{};
  std::vector<TrialRow> rows{};
  std::string ended{};  // in words, where it did not come to its end
};

/// All that a trial saw but the bytes. People send it in: nothing in it names one of them.
struct TrialReport {
  std::string kind{}, description{};  // of the device, by the config and by its driver
  std::vector<std::string> facts{};   // about the device's node and the machine
  std::vector<TriedStep> steps{};
  std::string bytes{};  // about those that follow
};

/// One row, in the words that people see.
std::string words_of(const TrialRow& row);

/// The report in lines; the first of them say what it holds. They are remarks of a file of device
/// bytes (byte_log.h), so that the one file that is sent in is a test case as it is.
std::vector<std::string> remarks_of(const TrialReport& report);

/// Writes a file that appears whole or not at all, in place of one of that name. A name that is a
/// pipe or a device is written to. Throws std::runtime_error in one line.
void save_whole(const std::string& path, const std::function<void(std::ostream&)>& write);

}  // namespace haptic
