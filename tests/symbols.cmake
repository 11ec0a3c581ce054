# SPDX-License-Identifier: GPL-3.0-or-later
# Fails when the servo's step refers to anything but itself, mathematics and the copying of memory:
# no allocation, exception, lock, input or output can then hide in it. Everything of ours that the
# objects call must be among the objects.
# Run: cmake -DNM=<nm> "-DOBJECTS=<a.o;b.o>" -P tests/symbols.cmake
# With "-DEXPECT=<symbol;symbol>" it succeeds only when each of these is refused.
cmake_minimum_required(VERSION 3.25)

# of libc and libm, nothing that allocates, locks or sets more than errno
set(allowed
  "mem(cpy|move|set|cmp)"
  "(sin|cos|sincos|tan|asin|acos|atan|atan2|sqrt|cbrt|exp|log|pow|hypot|ldexp|fmod|floor|ceil|round|trunc)f?"
  "(llround|lround|fmax|fmin|remainder|copysign)f?"
  "_GLOBAL_OFFSET_TABLE_"
  "__stack_chk_fail"
  # HAPTIC_ASSERT, where NDEBUG is not set: called only when a bug of ours is certain, to end the process
  "__assert_fail")
string(JOIN "|" allowed ${allowed})

# symbols of one kind in all objects, as nm names them
function(list_symbols option out)
  execute_process(COMMAND ${NM} -P ${option} ${OBJECTS}
    OUTPUT_VARIABLE text RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "symbols: '${NM}' cannot read ${OBJECTS}; build them first")
  endif()
  string(REGEX MATCHALL "[^\n]+" lines "${text}")
  list(FILTER lines EXCLUDE REGEX ":$")
  list(TRANSFORM lines REPLACE " .*" "")
  list(REMOVE_DUPLICATES lines)
  set(${out} ${lines} PARENT_SCOPE)
endfunction()

list_symbols(--undefined-only wanted)
list_symbols(--defined-only defined)
list(LENGTH defined count)
if(count EQUAL 0)
  message(FATAL_ERROR "symbols: nothing is defined in '${OBJECTS}'; name the objects of the step")
endif()
list(REMOVE_ITEM wanted ${defined})
set(refused ${wanted})
list(FILTER refused EXCLUDE REGEX "^(${allowed})$")

if(DEFINED EXPECT)
  foreach(symbol IN LISTS EXPECT)
    if(NOT symbol IN_LIST refused)
      message(SEND_ERROR "symbols: '${symbol}' is planted and was not refused; refused: ${refused}")
    endif()
  endforeach()
else()
  foreach(symbol IN LISTS refused)
    message(SEND_ERROR "the servo's step refers to '${symbol}' (see c++filt); keep it out of the \
pure files, or, if it is mathematics, add it to tests/symbols.cmake")
  endforeach()
endif()
message(STATUS "symbols: ${count} defined, outside are ${wanted}")
