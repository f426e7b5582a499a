# cmake -D PROGRAM=... [-D ARGUMENTS=...] [-D EXIT_CODE=0] [-D MATCHES=...] -P run_program.cmake
#
# Runs PROGRAM and fails unless it ends with EXIT_CODE and its output (both streams) matches. (The ctest property
# PASS_REGULAR_EXPRESSION would forget the exit code.)
if(NOT DEFINED EXIT_CODE)
  set(EXIT_CODE 0)
endif()
execute_process(COMMAND ${PROGRAM} ${ARGUMENTS} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
message("${output}")
if(NOT result STREQUAL EXIT_CODE)
  message(FATAL_ERROR "Exit code ${result} instead of ${EXIT_CODE}.")
elseif(DEFINED MATCHES AND NOT output MATCHES "${MATCHES}")
  message(FATAL_ERROR "The output does not match '${MATCHES}'.")
endif()
