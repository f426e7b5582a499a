# cmake -D PREFIX=<where it is installed> -D BUILD=<folder> -D PKG_CONFIG=... -D COMPILER=... -D VERSION=...
#       -P check_pkg_config.cmake
#
# A program compiled with what pkg-config says, after the installed tree was moved.
file(REMOVE_RECURSE ${BUILD})
file(COPY ${PREFIX}/ DESTINATION ${BUILD}/moved)
set(ENV{PKG_CONFIG_PATH} ${BUILD}/moved/share/pkgconfig:$ENV{PKG_CONFIG_PATH})

execute_process(COMMAND ${PKG_CONFIG} --modversion semiexplicit
  OUTPUT_VARIABLE version OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${PKG_CONFIG} --cflags semiexplicit
  OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
message("version ${version}, flags ${flags}")
if(NOT version STREQUAL VERSION)
  message(FATAL_ERROR "The version is ${version} instead of ${VERSION}.")
elseif(flags MATCHES "${PREFIX}/")
  message(FATAL_ERROR "The flags lead back to ${PREFIX}, from where the tree was moved away.")
endif()

separate_arguments(flags UNIX_COMMAND "${flags}")
execute_process(COMMAND ${COMPILER} -std=c++20 ${flags} ${CMAKE_CURRENT_LIST_DIR}/small/main.cpp -o ${BUILD}/small
  COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${BUILD}/small COMMAND_ERROR_IS_FATAL ANY)
