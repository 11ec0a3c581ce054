// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

namespace haptic {

/// A command of `hapt` that measures or checks something. These live in a separate program,
/// hapt-lab, so that running a session does not need the libraries they compare with; `hapt`
/// executes hapt-lab for them.
struct LabCommand {
  const char* name;
  const char* help;
};

inline constexpr LabCommand kEvalCommand{"eval", "Run a session offline in lockstep and judge it"};
inline constexpr LabCommand kBenchCommand{"bench",
                                          "Measure this machine; exit 1 where a goal is missed"};
inline constexpr LabCommand kSelftestCommand{
    "selftest", "Prove that the loop allocates, locks, faults and asks the kernel for nothing"};
inline constexpr LabCommand kTortureCommand{
    "torture",
    "Do faults at random to a session of its own, and judge the force by what the device received"};
inline constexpr std::array kLabCommands{&kEvalCommand, &kBenchCommand, &kSelftestCommand,
                                         &kTortureCommand};

}  // namespace haptic
