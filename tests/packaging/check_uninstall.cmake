# cmake -D BUILD=<build tree> -D PREFIX=<where it was installed> -P check_uninstall.cmake
file(GLOB_RECURSE before "${PREFIX}/*")
if(NOT before)
  message(FATAL_ERROR "Nothing is installed in ${PREFIX}, so there is nothing to test.")
endif()

execute_process(COMMAND ${CMAKE_COMMAND} --build "${BUILD}" --target uninstall COMMAND_ERROR_IS_FATAL ANY)

file(GLOB_RECURSE left "${PREFIX}/*")
if(left)
  message(FATAL_ERROR "uninstall left behind: ${left}")
endif()
# The prefix, and so the path to it, may have that name.
file(GLOB_RECURSE folders LIST_DIRECTORIES true RELATIVE "${PREFIX}" "${PREFIX}/*")
list(FILTER folders INCLUDE REGEX "(^|/)semiexplicit(/|$)")
if(folders)
  message(FATAL_ERROR "uninstall left empty folders behind: ${folders}")
endif()
