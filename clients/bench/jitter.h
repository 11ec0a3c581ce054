// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace haptic {

class Command;

/// `hapt bench jitter`: how late the servo's clock wakes, beside cyclictest, in alternation.
void add_bench_jitter(Command& bench);

}  // namespace haptic
