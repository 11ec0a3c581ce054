// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace haptic {

class Command;

/// `hapt bench qp`: times of the solvers in proto/math for one body at 1 to 64 contacts, compared
/// with CGAL's exact quadratic program and Bullet's Dantzig pivoting.
void add_bench_qp(Command& bench);

}  // namespace haptic
