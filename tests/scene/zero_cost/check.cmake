# cmake -D COMPILER=... -D OBJDUMP=... -D INCLUDES=... -D SOURCE=... -D WORK=... -P check.cmake
#
# Compiles SOURCE and compares the machine code of each pair of functions: <case>_in_scene has the floating-point arithmetic
# of <case>_by_hand, to the instruction, and hardly a move more. Vectorisation is off: it pairs equal arithmetic differently.
list(TRANSFORM INCLUDES PREPEND -I)
file(MAKE_DIRECTORY "${WORK}")
execute_process(
  COMMAND ${COMPILER} -std=c++20 -O2 -DNDEBUG -fno-math-errno -fno-tree-vectorize -fno-tree-slp-vectorize ${INCLUDES}
    -c ${SOURCE} -o ${WORK}/functions.o
  COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${OBJDUMP} -d --no-show-raw-insn ${WORK}/functions.o
  OUTPUT_VARIABLE dump COMMAND_ERROR_IS_FATAL ANY)
string(REGEX REPLACE "[];[]" "," dump "${dump}")  # what would end or join entries of a list
string(REPLACE "\n" ";" lines "${dump}")

set(function "")
foreach(line IN LISTS lines)
  if(line MATCHES "^[0-9a-f]+ <([a-z_]+)>:")
    set(function "${CMAKE_MATCH_1}")
    set(${function}_all 0)
    set(${function}_arithmetic "")
  elseif(function AND line MATCHES "^ +[0-9a-f]+:[ \t]+([a-z0-9]+)")
    set(instruction "${CMAKE_MATCH_1}")
    if(NOT line MATCHES "nop|xchg +%ax,%ax|int3")  # fills the gap between functions
      math(EXPR ${function}_all "${${function}_all} + 1")
    endif()
    if(instruction MATCHES "^(v?(add|sub|mul|div|sqrt)[sp]d|vfn?m(add|sub).*|f(add|sub|mul|div|sqrt|n?madd|n?msub))$")
      list(APPEND ${function}_arithmetic ${instruction})
    elseif(instruction MATCHES "^(call|callq|bl)$")
      message(FATAL_ERROR "${function} calls a function; everything should be inlined.")
    endif()
  endif()
endforeach()

foreach(case IN ITEMS two three half)
  set(by_hand ${${case}_by_hand_arithmetic})
  set(in_scene ${${case}_in_scene_arithmetic})
  list(SORT by_hand)
  list(SORT in_scene)
  list(LENGTH by_hand count)
  message("${case}: ${count} of arithmetic; in all ${${case}_by_hand_all} instructions by hand, "
    "${${case}_in_scene_all} in a scene")
  if(count LESS 5)
    message(FATAL_ERROR "The arithmetic of ${case}_by_hand was not found.")
  endif()
  if(NOT "${by_hand}" STREQUAL "${in_scene}")
    message(FATAL_ERROR "The arithmetic differs.\nby hand:  ${by_hand}\nin scene: ${in_scene}")
  endif()
  math(EXPR most "${${case}_by_hand_all} + 6")
  if(${case}_in_scene_all GREATER most)
    message(FATAL_ERROR "The scene moves more than the same sum by hand.")
  endif()
endforeach()
