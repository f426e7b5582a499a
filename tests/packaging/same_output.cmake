# cmake -D ONE=<program> -D OTHER=<program> -P same_output.cmake: both end well and print the same, and something.
foreach(program ONE OTHER)
  execute_process(COMMAND ${${program}} OUTPUT_VARIABLE ${program}_says COMMAND_ERROR_IS_FATAL ANY)
endforeach()
message("${ONE_says}")
if(NOT ONE_says STREQUAL OTHER_says OR ONE_says STREQUAL "")
  message(FATAL_ERROR "The other one says:\n${OTHER_says}")
endif()
