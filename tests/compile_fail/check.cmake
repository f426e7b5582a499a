# cmake -D SOURCE=... -D COMPILER=... -D INCLUDES=... -P check.cmake
#
# Compiles SOURCE and holds the compiler to the file's first line, which is one of
#   // compiles
#   // error names: TEXT
# A message must name TEXT, and be short: at most three errors (g++ makes three of a failed deduction) in 40 lines.
file(STRINGS "${SOURCE}" lines LIMIT_COUNT 1)
list(TRANSFORM INCLUDES PREPEND -I)
set(ENV{LC_ALL} C)  # messages in English
execute_process(COMMAND ${COMPILER} -std=c++20 -fsyntax-only ${INCLUDES} ${SOURCE}
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
message("${output}")

if(lines STREQUAL "// compiles")
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${SOURCE} must compile.")
  endif()
  return()
endif()

if(NOT lines MATCHES "^// error names: (.+)$")
  message(FATAL_ERROR "The first line of ${SOURCE} must say '// compiles' or '// error names: TEXT'.")
endif()
set(text "${CMAKE_MATCH_1}")
string(FIND "${output}" "${text}" found)
string(REGEX MATCHALL "error: " errors "${output}")
list(LENGTH errors error_count)
string(REGEX MATCHALL "\n" newlines "${output}")
list(LENGTH newlines line_count)
if(result EQUAL 0)
  message(FATAL_ERROR "${SOURCE} must not compile.")
elseif(found EQUAL -1)
  message(FATAL_ERROR "The compiler's message does not name '${text}'.")
elseif(error_count GREATER 3 OR line_count GREATER 40)
  message(FATAL_ERROR "The message is too long: ${error_count} errors in ${line_count} lines.")
endif()
