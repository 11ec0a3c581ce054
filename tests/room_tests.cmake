# SPDX-License-Identifier: GPL-3.0-or-later
# Tests of the rooms, one program each; included by CMakeLists.txt.
haptic_tests(proto LIBRARIES haptic_proto haptic_command_line SOURCES
  proto/config_test.cpp proto/config_tool_test.cpp
  proto/control_socket_test.cpp
  proto/hand_trace_test.cpp
  proto/handout_test.cpp proto/handout_hostile_test.cpp proto/mcap_hostile_test.cpp
  proto/message_test.cpp proto/quantity_test.cpp proto/realtime_test.cpp
  proto/regular_file_test.cpp
  proto/ring_model_test.cpp
  proto/ring_test.cpp
  proto/segment_fuzz_test.cpp
  proto/segment_hostile_test.cpp
  proto/segment_test.cpp
  proto/trace_test.cpp)
haptic_tests(math LIBRARIES haptic_proto Eigen3::Eigen SOURCES
  proto/coupling_margin_test.cpp proto/mapping_test.cpp proto/math_test.cpp
  proto/project_point_test.cpp proto/qp_test.cpp proto/lcp_test.cpp proto/coulomb_test.cpp)
haptic_tests(rt_guard LIBRARIES haptic_rt_guard haptic_rt_guard_hooks SOURCES
  proto/rt_guard_kernel_test.cpp
  proto/rt_guard_test.cpp)
# functions by name in what it reports
set_target_properties(test_rt_guard PROPERTIES ENABLE_EXPORTS ON)
# what is done to a mesh before anybody touches it
haptic_tests(contact NAME bake LIBRARIES haptic_bake SOURCES
  contact/bake_polygons_test.cpp contact/bake_read_test.cpp contact/bake_test.cpp contact/baked_file_test.cpp
  contact/bake_volume_test.cpp)
haptic_tests(contact LIBRARIES haptic_servo haptic_bake cgal_pairs SOURCES
  contact/bake_extent_test.cpp contact/bake_pipe_test.cpp contact/body_detectors_test.cpp
  contact/clear_pose_test.cpp contact/closest_point_test.cpp contact/hash_grid_test.cpp
  contact/near_features_test.cpp contact/obb_tree_test.cpp contact/patch_tree_test.cpp contact/point_proxy_test.cpp contact/segment_hit_test.cpp
  contact/sphere_proxy_test.cpp
  contact/step_test.cpp
  contact/swept_sphere_test.cpp contact/voxmap_test.cpp contact/distance_field_test.cpp contact/pointshell_test.cpp
  contact/voxel_scan_test.cpp contact/shell_in_field_test.cpp contact/cluster_pushes_test.cpp contact/shell_pushes_test.cpp contact/voxel_test.cpp contact/machine_parts_test.cpp
  contact/triangle_pairs_test.cpp contact/exact_test.cpp contact/vertex_fan_test.cpp contact/voxel_tree_test.cpp contact/soft_loop_test.cpp contact/interval_test.cpp contact/swept_pair_test.cpp contact/swept_mesh_test.cpp contact/obb_overlap_test.cpp contact/triangle_distance_test.cpp contact/near_pairs_test.cpp contact/near_front_follow_test.cpp contact/sliding_planes_test.cpp contact/god_object6_test.cpp contact/rigid_tool_test.cpp contact/near_contacts_test.cpp contact/conservative_advancement_test.cpp)
# any bytes for whoever reads files
haptic_tests(fuzz LIBRARIES haptic_hapticd haptic_bake SOURCES
  fuzz/cache_fuzz_test.cpp fuzz/config_fuzz_test.cpp fuzz/fuzz_meter.cpp fuzz/log_fuzz_test.cpp
  fuzz/mesh_fuzz_test.cpp fuzz/mesh_inputs.cpp fuzz/socket_fuzz_test.cpp
  fuzz/trace_fuzz_test.cpp)
haptic_tests(device LIBRARIES haptic_device SOURCES
  device-io/answer_match_test.cpp
  device-io/emulator_firmware_test.cpp
  device-io/encoder_noise_test.cpp
  device-io/hand_plant_test.cpp
  device-io/intent_test.cpp
  device-io/lying_device_test.cpp
  device-io/replay_test.cpp
  device-io/simulated_hand_test.cpp
  device-io/woodenhaptics_kinematics_test.cpp
  device-io/woodenhaptics_protocol_test.cpp
  device-io/woodenhaptics_test.cpp)
haptic_tests(servo LIBRARIES haptic_servo haptic_hapticd haptic_contact SOURCES
  servo/contact_age_test.cpp
  servo/coupling_test.cpp
  servo/command_test.cpp
  servo/passivity_test.cpp
  servo/patient_sink_test.cpp
  servo/penalty_dynamics_test.cpp
  servo/free_space_test.cpp servo/quasi_static_test.cpp servo/soft_contacts_test.cpp servo/soft_proxy_test.cpp
  servo/restart_policy_test.cpp
  servo/safety_test.cpp
  servo/step_test.cpp servo/render_body_test.cpp servo/render_rigid_test.cpp servo/god_object6_test.cpp servo/constrained6_test.cpp
  servo/surface_test.cpp)
haptic_tests(sim LIBRARIES haptic_sim SOURCES sim/scene_test.cpp)
haptic_tests(lab LIBRARIES haptic_lab haptic_torture SOURCES
  clients/bench_burst_test.cpp clients/step_budget_test.cpp clients/ccd_queries_test.cpp
  clients/eval_oracle_test.cpp
  clients/eval_free_test.cpp clients/eval_moving_test.cpp
  clients/eval_place_test.cpp clients/eval_quality_test.cpp clients/eval_rigid_test.cpp
  clients/eval_rest_test.cpp
  clients/eval_renderer_test.cpp
  clients/emulated_hands_test.cpp
  clients/eval_ruffaldi_test.cpp
  clients/eval_sphere_oracle_test.cpp
  clients/eval_workload_test.cpp
  clients/force_judge_test.cpp
  clients/god_object_test.cpp
  clients/jitter_rows_test.cpp
  clients/lockstep_test.cpp
  clients/penalty_test.cpp
  clients/plot_test.cpp
  clients/torture_account_test.cpp
  clients/virtual_proxy_test.cpp
  clients/wake_lateness_test.cpp)
haptic_tests(threads LIBRARIES haptic_hapticd haptic_torture haptic_guarded_loop haptic_rt_guard_hooks SOURCES
  servo/device_guard_test.cpp clients/recorder_test.cpp clients/process_waits_test.cpp clients/guarded_loop_test.cpp)

# the ring as it is in the programs: what the optimiser does with it is what these look at
if(NOT HAPTIC_SANITIZE)
  set_source_files_properties(proto/ring_test.cpp proto/ring_model_test.cpp
    process/ring_torture_test.cpp PROPERTIES COMPILE_OPTIONS -O2)
endif()
