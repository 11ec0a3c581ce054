# SPDX-License-Identifier: GPL-3.0-or-later
# Tests on the real programs, in three: sessions, with what the sanitizers look at; faults in them;
# and `hapt` with its lab. They wait more than they work, and begin first. A sanitizer makes the
# real-time processes of a session so heavy that a second one leaves no time to who watches.
set(alone)
if(HAPTIC_SANITIZE)
  set(alone ALONE)
endif()
haptic_tests(process ${alone} COST 10 LIBRARIES haptic_device SOURCES
  process/chain_test.cpp
  process/emulator_test.cpp
  process/recording_test.cpp
  process/session_test.cpp)
haptic_tests(process NAME faults ${alone} COST 20 LIBRARIES haptic_torture SOURCES
  process/fault_contact_test.cpp
  process/fault_device_test.cpp
  process/fault_session_test.cpp)
haptic_tests(process NAME hapt ${alone} COST 20 LIBRARIES haptic_torture SOURCES
  process/hapt_bench_test.cpp
  process/hapt_test.cpp
  process/hostile_messages_test.cpp
  process/quantities_test.cpp
  process/rate_test.cpp
  process/ring_torture_test.cpp
  process/selftest_test.cpp)
# they start them
add_dependencies(test_process hapt hapticd haptic-sim haptic-contact haptic-servo haptic-emulator)
add_dependencies(test_faults hapticd haptic-sim haptic-faulty-contact haptic-servo haptic-emulator
  hapt hapt-lab)
add_dependencies(test_hapt hapt hapt-lab hapticd haptic-sim haptic-contact haptic-servo
  haptic-emulator 01_watch)
