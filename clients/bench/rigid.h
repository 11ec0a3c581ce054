// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace haptic {

class Command;

/// `hapt bench rigid`: the 6-DoF god-object while a hand shakes it against walls at 1 kHz: times of
/// a move, and that no verified pose is ever inside or held back without contact. FCL's distance at
/// the same poses for comparison.
void add_bench_rigid(Command& bench);

}  // namespace haptic
