# SPDX-License-Identifier: GPL-3.0-or-later
# Tests on the real programs; included by CMakeLists.txt.
haptic_tests(process LIBRARIES haptic_torture SOURCES
  process/chain_test.cpp
  process/emulator_test.cpp
  process/fault_contact_test.cpp
  process/fault_device_test.cpp
  process/fault_session_test.cpp
  process/hapt_bench_test.cpp
  process/hapt_test.cpp
  process/ring_torture_test.cpp
  process/rate_test.cpp
  process/selftest_test.cpp
  process/session_test.cpp)
# it starts them
add_dependencies(test_process hapt hapticd haptic-sim haptic-contact haptic-faulty-contact
  haptic-servo haptic-emulator 01_watch)
