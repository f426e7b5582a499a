# cmake -D BUILD=<build tree> -D PREFIX=<where it was installed> -P check_uninstall.cmake
file(GLOB_RECURSE before "${PREFIX}/*")
if(NOT before)
  message(FATAL_ERROR "Nothing is installed in ${PREFIX}, so there is nothing to test.")
endif()

# From elsewhere nothing is removed, which is said, and the list is kept.
execute_process(COMMAND ${CMAKE_COMMAND} -E env DESTDIR=/nowhere ${CMAKE_COMMAND} --build "${BUILD}" --target uninstall
  RESULT_VARIABLE result OUTPUT_VARIABLE said ERROR_VARIABLE said)
if(result EQUAL 0 OR NOT said MATCHES "Nothing was removed" OR NOT EXISTS "${BUILD}/install_manifest.txt")
  message(FATAL_ERROR "uninstall from elsewhere gave ${result} and said: ${said}")
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
