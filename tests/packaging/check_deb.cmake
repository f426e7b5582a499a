# cmake -D SOURCE=<project> -D BUILD=<folder> -D CPACK=... -D COMPILER=... -D Eigen3_DIR=... -D GENERATOR=... -D VERSION=...
#       -P check_deb.cmake
#
# Makes the Debian package, unpacks it into a folder of its own (installing it would need rights), and has a program use it.
file(REMOVE_RECURSE ${BUILD})
set(same_tools -G ${GENERATOR} -D CMAKE_CXX_COMPILER=${COMPILER} -D Eigen3_DIR=${Eigen3_DIR})
execute_process(
  COMMAND ${CMAKE_COMMAND} -S ${SOURCE} -B ${BUILD}/library ${same_tools} -D SEMIEXPLICIT_BUILD_TESTS=OFF
    -D SEMIEXPLICIT_BUILD_EXAMPLES=OFF -D SEMIEXPLICIT_BUILD_BENCHMARKS=OFF
  COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CPACK} -G DEB WORKING_DIRECTORY ${BUILD}/library COMMAND_ERROR_IS_FATAL ANY)

set(package ${BUILD}/library/libsemiexplicit-dev_${VERSION}_all.deb)
execute_process(COMMAND dpkg-deb --field ${package} OUTPUT_VARIABLE fields COMMAND_ERROR_IS_FATAL ANY)
message("${fields}")
foreach(field "Package: libsemiexplicit-dev" "Architecture: all" "Depends: libeigen3-dev")
  if(NOT fields MATCHES "${field}")
    message(FATAL_ERROR "The package does not say '${field}'.")
  endif()
endforeach()

set(root ${BUILD}/root)
execute_process(COMMAND dpkg-deb --extract ${package} ${root} COMMAND_ERROR_IS_FATAL ANY)
if(NOT EXISTS ${root}/usr/share/doc/libsemiexplicit-dev/copyright)
  message(FATAL_ERROR "The licence is not where Debian wants it.")
endif()

execute_process(
  COMMAND ${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/small -B ${BUILD}/small ${same_tools}
    -D CMAKE_PREFIX_PATH=${root}/usr -D CMAKE_BUILD_TYPE=Debug
  COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} --build ${BUILD}/small COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${BUILD}/small/small COMMAND_ERROR_IS_FATAL ANY)
