# SPDX-License-Identifier: GPL-3.0-or-later
# hapt-lab: the commands of `hapt` that measure and prove; a session needs none of it

# the offline lab: all three steps in one process on virtual time
add_library(haptic_lab STATIC
  bench_workload.cpp
  ccd_queries.cpp
  cyclictest.cpp
  jitter_rows.cpp
  lockstep.cpp
  redon_intervals.cpp
  shaking_hand.cpp
  step_budget.cpp
  traj.cpp
  wake_lateness.cpp)
target_link_libraries(haptic_lab PUBLIC haptic_judge haptic_servo haptic_sim haptic_device)
include(eval.cmake)

# the proof of the loop; what uses it links the hooks of rt_guard too
add_library(haptic_guarded_loop STATIC guarded_loop.cpp)
target_link_libraries(haptic_guarded_loop
  PUBLIC haptic_servo_loop haptic_bake haptic_sim haptic_rt_guard)

# faults in a running session, and the judge of what the hand received meanwhile
add_library(haptic_torture STATIC
  faults.cpp
  force_judge.cpp
  process_waits.cpp
  stall_witness.cpp
  torture_account.cpp
  torture_session.cpp)
target_link_libraries(haptic_torture PUBLIC haptic_client haptic_commands haptic_device)

# peers of the benchmarks; CGAL puts -frounding-math on its target, so it gets its own
add_library(haptic_cgal_peers STATIC bench_closest_cgal_peers.cpp)
target_link_libraries(haptic_cgal_peers PUBLIC haptic_contact PRIVATE CGAL::CGAL)
set_target_properties(haptic_cgal_peers PROPERTIES JOB_POOL_COMPILE heavy)
find_package(embree 3 CONFIG QUIET)
if(embree_FOUND)
  set_source_files_properties(bench_closest_embree_peers.cpp PROPERTIES
    COMPILE_DEFINITIONS HAPTIC_HAS_EMBREE)
endif()

add_executable(hapt-lab
  bench_bake.cpp
  bench_ccd.cpp
  bench_closest.cpp
  bench_closest_embree_peers.cpp
  bench_jitter.cpp
  bench_point_proxy.cpp
  bench_proximity.cpp bench_proximity_work.cpp
  bench_qp.cpp
  bench_rigid.cpp
  bench_ring.cpp
  bench_segment.cpp
  bench_turns.cpp
  bench_voxel.cpp
  bench_voxel_ceiling.cpp
  bench_voxel_contact.cpp
  hapt_bench.cpp
  hapt_eval.cpp
  hapt_lab.cpp
  hapt_selftest.cpp
  hapt_torture.cpp
  run_hapt.cpp)
target_link_libraries(hapt-lab
  PRIVATE haptic_lab haptic_torture haptic_guarded_loop haptic_rt_guard_hooks haptic_cgal_peers
  haptic_commands haptic_command_line $<$<BOOL:${embree_FOUND}>:embree>)
# `hapt torture` starts it
add_dependencies(hapt-lab haptic-faulty-contact)
# the functions on a violation's stack by name
set_target_properties(hapt-lab PROPERTIES ENABLE_EXPORTS ON)

include(bench_peers.cmake)
