# SPDX-License-Identifier: GPL-3.0-or-later
# the judge of renderers: workloads, oracles, what they say of a run
target_sources(haptic_lab PRIVATE
  eval_artefacts.cpp
  eval_drag.cpp
  eval_facets.cpp
  eval_free.cpp
  eval_free_hands.cpp
  eval_free_scenes.cpp
  eval_friction.cpp
  eval_judge.cpp
  eval_moving.cpp
  eval_moving_scenes.cpp
  eval_oracle.cpp
  eval_place.cpp
  eval_quality.cpp
  eval_quality_scenes.cpp
  eval_renderer.cpp
  eval_rest.cpp
  eval_rest_gyroid.cpp
  eval_rest_work.cpp
  eval_rigid.cpp
  eval_rigid_judge.cpp
  eval_rigid_scenes.cpp
  eval_ruffaldi.cpp
  eval_sphere_oracle.cpp
  eval_table.cpp
  eval_walls.cpp
  eval_workload.cpp)

# oracles; CGAL puts -frounding-math on its whole target, so they are apart
add_library(haptic_eval_cgal STATIC eval_exact_cgal.cpp eval_free_cgal.cpp eval_rest_cgal.cpp)
target_link_libraries(haptic_eval_cgal PUBLIC haptic_contact PRIVATE CGAL::CGAL)
target_compile_options(haptic_eval_cgal PRIVATE -O1)
set_target_properties(haptic_eval_cgal PROPERTIES
  JOB_POOL_COMPILE heavy HAPTIC_WITHOUT_THREADS ON)
target_link_libraries(haptic_lab PUBLIC haptic_eval_cgal)
