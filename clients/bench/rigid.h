// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace haptic {

class Command;

/// `hapt bench rigid`: the god-object of six degrees of freedom while a hand shakes it against
/// walls, tick by tick of 1 kHz: how long a move takes, and that no verified pose is ever inside,
/// none held back but by contacts. FCL's distance at the same poses beside it.
void add_bench_rigid(Command& bench);

}  // namespace haptic
