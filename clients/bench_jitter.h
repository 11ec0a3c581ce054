// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace CLI {  // NOLINT(readability-identifier-naming): of the library
class App;
}

namespace haptic {

/// `hapt bench jitter`: how late the servo's clock wakes, beside cyclictest, in alternation.
void add_bench_jitter(CLI::App& bench);

}  // namespace haptic
