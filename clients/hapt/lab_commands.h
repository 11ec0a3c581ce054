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

inline constexpr LabCommand kEvalCommand{
    "eval", "Run a session offline on a virtual clock, or compare renderers"};
inline constexpr LabCommand kBenchCommand{
    "bench", "Measure this machine, in alternation with peer libraries"};
inline constexpr LabCommand kSelftestCommand{
    "selftest", "Check that the servo loop makes no allocation, lock, page fault or system call"};
inline constexpr LabCommand kTortureCommand{
    "torture",
    "Fault injection: break a private test session at random and check the forces sent to the "
    "device"};
inline constexpr std::array kLabCommands{&kEvalCommand, &kBenchCommand, &kSelftestCommand,
                                         &kTortureCommand};

}  // namespace haptic
