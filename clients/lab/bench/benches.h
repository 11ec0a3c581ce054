// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "clients/report/report.h"

namespace haptic {

class Command;

/// Runs a bench; benches without the option --rounds ignore `rounds`.
using BenchRun = std::function<std::vector<Row>(int rounds)>;

/// Runs a bench whose options hold the rounds.
template <class Options>
BenchRun run_rounds(std::shared_ptr<Options> options, std::vector<Row> (*rows)(const Options&)) {
  return [options, rows](int rounds) {
    options->rounds = rounds;
    return rows(*options);
  };
}

// Each of these adds the bench's own options to its command and returns what runs with them.

/// The preparation of a mesh of 1.1 M triangles for queries: trees and grid built from memory,
/// their size, and the whole shape mapped from the cache.
BenchRun bench_bake(Command& command);

/// Continuous collision detection compared with its peers in the same run: vertex–face and
/// edge–edge on exact ground truth (false alarms and misses per file) and on queries at the scale
/// of a hand, against FCL and Redon's intervals; time of impact of two tori of 27 k and 40 k
/// triangles along motions of a hand at 1 kHz, checked by exact intersection at many earlier times.
BenchRun bench_ccd(Command& command);

/// Cost of the closest point on a mesh, with and without warm start, compared with Embree's point
/// query and CGAL's AABB tree. Workload W2: points dragged within 1 mm of the surface, and random
/// ones up to 20 mm outside. Errors are against brute force on a sample, and on all points between
/// the answers with and without warm start.
BenchRun bench_closest(Command& command);

/// Wake-up lateness of the servo's clock, in alternation with cyclictest.
BenchRun bench_jitter(Command& command);

/// Cost of a whole contact step of virtual-proxy3 on the benchmark set: CPU time of the thread
/// (CLOCK_THREAD_CPUTIME_ID minus the cost of reading it) of each tick, the least of the
/// repetitions, which excludes disturbances by the machine. One further pass reports what rt_guard
/// catches and how many contacts there are.
BenchRun bench_point_proxy(Command& command);

/// Contact levels of detail: whole contact steps of voxel, sensation, localized, direct6 and
/// god-object6 on the same poses of pairs in contact over much of their surface, in turns, with the
/// force of each and its error against the exact queries (every piece, every triangle).
BenchRun bench_lod(Command& command);

/// How long a device on a serial node takes to answer the line of docs/six-motors.md, asked once a
/// tick with zero currents: from before the write to after the read.
BenchRun bench_line(Command& command);

/// Penetration depth of two convex hulls of 20 to 500 vertices at coherent poses (workload W4),
/// compared with Bullet's GJK–EPA in double, libccd and FCL, and with our own polytope for the
/// exact depth; then their distance at poses apart, compared with FCL. A time is the least of the
/// rounds for each query.
BenchRun bench_penetration(Command& command);

/// All pairs of triangles within 0.1 mm, from scratch and with a bounding-volume-tree front kept
/// from pose to pose, and their reduction to contacts, compared with FCL's collision and distance
/// (W3).
BenchRun bench_proximity(Command& command);

/// Times of the solvers in proto/math for one body at 1 to 64 contacts, compared with CGAL's exact
/// quadratic program and Bullet's Dantzig pivoting.
BenchRun bench_qp(Command& command);

/// The 6-DoF god-object while a hand shakes it against walls at 1 kHz: times of a move, and that no
/// verified pose is ever inside or held back without contact. FCL's distance at the same poses for
/// comparison.
BenchRun bench_rigid(Command& command);

/// Cost of the ring between two processes, each on its own processor at SCHED_FIFO if granted;
/// refused rights are reported in a row.
///
/// One way: from before the writer's copy to after the reader's, one message at a time, so that no
/// backlog is measured. Throughput: with credit, so that nothing is lost; the queue blocks instead.
/// Publish: a whole ServoFrame into the servo's segment. Ring and queue alternate within each
/// round; a figure is the median over the rounds.
BenchRun bench_ring(Command& command);

/// First hit of a dragged probe (workload W1), in alternation with other libraries, and the ratios
/// hybrid : grid : tree : naive.
BenchRun bench_segment(Command& command);

/// The cost of viewers of `hapt view`: the servo's work and the bridge's own time of the processor,
/// with none, with many at 120 Hz, with one that is stopped and with one that reads a byte now and
/// then, in turns in one session; a figure is the median over the rounds.
BenchRun bench_view(Command& command);

/// Points of a shell tested per microsecond of CPU time on one core in maps of a bumpy sphere:
/// Morton order and shuffled, scalar and SIMD; compared with a ceiling that does the same arithmetic
/// and loads only. Then for an object with many more triangles, the share of
/// points of a passing tool that temporal coherence leaves to be tested, and whole contact steps.
BenchRun bench_voxel(Command& command);

/// Objects with mass: CPU time of sim's step for a wall of fifteen bricks of which one is pushed,
/// in turns with Bullet's own stepping of the same wall; then live sessions with masses and
/// without, in turns: the servo's work and the rate of contact.
BenchRun bench_world(Command& command);

}  // namespace haptic
