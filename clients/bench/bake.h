// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace haptic {

class Command;

/// `hapt bench bake`: what a mesh of 1.1 M triangles takes until queries can be asked: trees and
/// grid from memory, their size, and the whole shape mapped from the cache.
void add_bench_bake(Command& bench);

}  // namespace haptic
