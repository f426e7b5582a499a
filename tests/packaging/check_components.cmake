# cmake -D PREFIX=<where it is installed> -D BUILD=<folder> -D GENERATOR=... -D COMPILER=... -D Eigen3_DIR=...
#   -P check_components.cmake
#
# What find_package(semiexplicit COMPONENTS ...) gives and what it refuses, and the versions of Eigen that it takes.

# looks(<settings>... [COMPLAINT <regex>] [SAYS <regex>]): find_package succeeds and prints what matches SAYS, or fails with
# what matches COMPLAINT.
function(looks)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "COMPLAINT;SAYS" "")
  file(REMOVE_RECURSE ${BUILD})
  execute_process(
    COMMAND ${CMAKE_COMMAND} -G ${GENERATOR} -S ${CMAKE_CURRENT_LIST_DIR}/components -B ${BUILD}
      -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_PREFIX_PATH=${PREFIX} -D Eigen3_DIR=${Eigen3_DIR} ${arg_UNPARSED_ARGUMENTS}
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE complaint)
  string(REGEX REPLACE "[ \n]+" " " complaint "${complaint}") # CMake breaks the lines of a message
  message("${arg_UNPARSED_ARGUMENTS}: ${result}, ${complaint}")
  if(DEFINED arg_COMPLAINT AND NOT (result AND complaint MATCHES "${arg_COMPLAINT}"))
    message(FATAL_ERROR "It should have been refused with '${arg_COMPLAINT}'.")
  elseif(NOT DEFINED arg_COMPLAINT AND result)
    message(FATAL_ERROR "It should have been found.")
  elseif(DEFINED arg_SAYS AND NOT output MATCHES "${arg_SAYS}")
    message(FATAL_ERROR "It should have said '${arg_SAYS}': ${output}")
  endif()
endfunction()

looks(-D WANTED=boost)
looks(-D VERSION=99.0 COMPLAINT "compatible with requested version \"99.0\"")
looks(-D WANTED=boots COMPLAINT "no component 'boots'. the components are boost, openmp")
looks(-D WANTED=boost -D CMAKE_DISABLE_FIND_PACKAGE_Boost=ON COMPLAINT "component boost needs the headers of Boost .*libboost-dev")
looks(-D OPTIONAL=boost -D CMAKE_DISABLE_FIND_PACKAGE_Boost=ON SAYS "optional boost: (FALSE|0)?\n")

set(Eigen3_DIR ${CMAKE_CURRENT_LIST_DIR}/eigen)
looks(-D PRETENDED_EIGEN=5.0.0)
looks(-D PRETENDED_EIGEN=3.3.9 COMPLAINT "needs Eigen 3.4 or later, but .* is Eigen 3.3.9")
