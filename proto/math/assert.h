// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cassert>

/// States what the code trusts: a precondition, an invariant, the room in an array. Where it does
/// not hold the process ends with the condition, file and line; with NDEBUG (the release preset)
/// nothing is checked or evaluated, so a condition has no side effects, and what it names must
/// exist all the same.
///
/// An assertion is for a bug of the caller, in this process. What comes from outside (a file, a
/// device, another process, a person) may be wrong at any time: that gives an error line, a flag or
/// a zero wrench. So nothing here asserts what a ring, a config or a sample holds.
#ifdef NDEBUG
// named but not evaluated: a variable that only an assertion uses is used in every build
#define HAPTIC_ASSERT(condition) static_cast<void>(sizeof((condition) ? 1 : 0))
#else
#define HAPTIC_ASSERT(condition) assert(condition)
#endif
