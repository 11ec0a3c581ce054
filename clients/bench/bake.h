// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace haptic {

class Command;

/// `hapt bench bake`: the preparation of a mesh of 1.1 M triangles for queries: trees and grid
/// built from memory, their size, and the whole shape mapped from the cache.
void add_bench_bake(Command& bench);

}  // namespace haptic
