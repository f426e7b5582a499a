# cmake -D PORT=<folder of the port> -D BUILD=<folder> -D COMPILER=... -D Eigen3_DIR=... -D GENERATOR=... -D VERSION=...
#       -P check_vcpkg.cmake
#
# Runs the port with stand-ins for vcpkg's own functions that do what those do to the files: are all paths right, and is what
# is left the library?
file(READ ${PORT}/vcpkg.json manifest)
string(JSON version GET "${manifest}" version-semver)
if(NOT version STREQUAL VERSION)
  message(FATAL_ERROR "vcpkg.json has version ${version}, and version.hpp ${VERSION}.")
endif()

set(CURRENT_PACKAGES_DIR ${BUILD}/package)
file(REMOVE_RECURSE ${BUILD})

function(vcpkg_cmake_configure)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "SOURCE_PATH" "OPTIONS")
  execute_process(COMMAND ${CMAKE_COMMAND} -S ${arg_SOURCE_PATH} -B ${BUILD}/build -G ${GENERATOR} ${arg_OPTIONS}
    -D CMAKE_CXX_COMPILER=${COMPILER} -D Eigen3_DIR=${Eigen3_DIR} -D CMAKE_INSTALL_PREFIX=${CURRENT_PACKAGES_DIR}
    COMMAND_ERROR_IS_FATAL ANY)
endfunction()
function(vcpkg_cmake_install)
  execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD}/build COMMAND_ERROR_IS_FATAL ANY)
endfunction()
function(vcpkg_cmake_config_fixup)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "PACKAGE_NAME;CONFIG_PATH" "")
  file(RENAME ${CURRENT_PACKAGES_DIR}/${arg_CONFIG_PATH} ${CURRENT_PACKAGES_DIR}/share/${arg_PACKAGE_NAME})
endfunction()
function(vcpkg_fixup_pkgconfig)
endfunction()
function(vcpkg_install_copyright)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "" "FILE_LIST")
  file(COPY_FILE ${arg_FILE_LIST} ${CURRENT_PACKAGES_DIR}/share/semiexplicit/copyright)
endfunction()

include(${PORT}/portfile.cmake)

foreach(file include/semiexplicit/semiexplicit.hpp share/pkgconfig/semiexplicit.pc share/semiexplicit/semiexplicitConfig.cmake
    share/semiexplicit/copyright)
  if(NOT EXISTS ${CURRENT_PACKAGES_DIR}/${file})
    message(FATAL_ERROR "The port leaves no ${file}.")
  endif()
endforeach()
