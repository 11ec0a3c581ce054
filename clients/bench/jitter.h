// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace haptic {

class Command;

/// `hapt bench jitter`: wake-up lateness of the servo's clock, in alternation with cyclictest.
void add_bench_jitter(Command& bench);

}  // namespace haptic
