# cmake -D PROGRAM=... -D "ARGUMENTS=..." -D FOLDER=... [-D EXIT_CODE=0] [-D COMPLAINT=regex] [-D FILE=... [-D HEADER=...]]
#       [-D ABSENT=...] [-D PRINTS=regex] [-D PATH=...] -P check.cmake
#
# Runs PROGRAM in FOLDER, emptied before, and fails unless it ends with EXIT_CODE; writes one line that matches COMPLAINT
# to stderr, or nothing where none is given; prints what matches PRINTS; leaves FILE, whose first line is HEADER; leaves
# neither ABSENT nor half a file. PATH replaces the search path.
if(NOT DEFINED EXIT_CODE)
  set(EXIT_CODE 0)
endif()
file(REMOVE_RECURSE "${FOLDER}")
file(MAKE_DIRECTORY "${FOLDER}")
if(DEFINED PATH)
  set(ENV{PATH} "${PATH}")
endif()

separate_arguments(ARGUMENTS UNIX_COMMAND "${ARGUMENTS}")
execute_process(COMMAND ${PROGRAM} ${ARGUMENTS} WORKING_DIRECTORY "${FOLDER}"
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE complaint)
message("${output}${complaint}")
# What Open MPI's libraries say where a container hides the processor is not the program's.
string(REGEX REPLACE "\\[hwloc/[^\n]*\n" "" complaint "${complaint}")

if(NOT result STREQUAL EXIT_CODE)
  message(FATAL_ERROR "Exit code ${result} instead of ${EXIT_CODE}.")
endif()
if(DEFINED COMPLAINT)
  if(NOT complaint MATCHES "^[^\n]*${COMPLAINT}[^\n]*\n$")
    message(FATAL_ERROR "The complaint is not one line that matches '${COMPLAINT}'.")
  endif()
elseif(NOT complaint STREQUAL "")
  message(FATAL_ERROR "There should be nothing on stderr.")
endif()
if(DEFINED PRINTS AND NOT output MATCHES "${PRINTS}")
  message(FATAL_ERROR "Nothing in the output matches '${PRINTS}'.")
endif()
if(DEFINED FILE)
  file(STRINGS "${FOLDER}/${FILE}" rows)
  list(GET rows 0 header)
  list(LENGTH rows count)
  if(DEFINED HEADER AND NOT header STREQUAL HEADER)
    message(FATAL_ERROR "${FILE} begins with '${header}' instead of '${HEADER}'.")
  elseif(count LESS 3)
    message(FATAL_ERROR "${FILE} has next to nothing in it.")
  endif()
endif()
if(DEFINED ABSENT AND EXISTS "${FOLDER}/${ABSENT}")
  message(FATAL_ERROR "${ABSENT} should not be there.")
endif()
file(GLOB_RECURSE parts "${FOLDER}/*.part")
if(parts)
  message(FATAL_ERROR "Half a file was left behind: ${parts}.")
endif()
