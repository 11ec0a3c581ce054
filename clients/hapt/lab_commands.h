// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

namespace haptic {

/// A command of `hapt` that lives in a separate program, which `hapt` executes for it: so running a
/// session does not need the libraries that measurements compare with (hapt-lab), nor those of a
/// web server (haptic-view).
struct LabCommand {
  const char* name;
  const char* help;
  const char* program = "hapt-lab";
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
inline constexpr LabCommand kZwidthCommand{
    "zwidth", "Largest stable stiffness of a device in a hand, over damping, by bisection"};
inline constexpr LabCommand kPassivityCommand{
    "passivity", "Margin of stability of a coupling in any hand and at any object, over frequency"};
inline constexpr LabCommand kBodeCommand{
    "bode", "Impedance that the servo renders, over frequency, against the intended one"};
inline constexpr LabCommand kViewCommand{
    "view", "Show a running session or a recording in a browser", "haptic-view"};
inline constexpr std::array kLabCommands{&kEvalCommand,    &kBenchCommand,  &kSelftestCommand,
                                         &kTortureCommand, &kZwidthCommand, &kPassivityCommand,
                                         &kBodeCommand,    &kViewCommand};

}  // namespace haptic
