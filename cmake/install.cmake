# Installs the headers, a package for find_package(semiexplicit) and a file for pkg-config; `uninstall` takes them away again.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_DATADIR}/cmake/semiexplicit)

target_include_directories(semiexplicit INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/semiexplicit
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  FILES_MATCHING PATTERN "*.hpp")
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

install(TARGETS semiexplicit EXPORT semiexplicitTargets)
install(EXPORT semiexplicitTargets NAMESPACE semiexplicit:: DESTINATION ${package_dir})
configure_package_config_file(
  ${CMAKE_CURRENT_LIST_DIR}/semiexplicitConfig.cmake.in ${PROJECT_BINARY_DIR}/semiexplicitConfig.cmake
  INSTALL_DESTINATION ${package_dir}
  NO_SET_AND_CHECK_MACRO)
# Before 1.0 a new minor version may change the interface. From 1.0 on: SameMajorVersion.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/semiexplicitConfigVersion.cmake
  COMPATIBILITY SameMinorVersion
  ARCH_INDEPENDENT)
install(FILES
  ${PROJECT_BINARY_DIR}/semiexplicitConfig.cmake
  ${PROJECT_BINARY_DIR}/semiexplicitConfigVersion.cmake
  ${CMAKE_CURRENT_LIST_DIR}/components.cmake
  DESTINATION ${package_dir})

# The prefix is found from where the file lies, so that an installed tree may be moved.
set(pkgconfig_dir ${CMAKE_INSTALL_DATADIR}/pkgconfig)
if(IS_ABSOLUTE ${pkgconfig_dir})
  set(pkgconfig_prefix ${CMAKE_INSTALL_PREFIX})
else()
  file(RELATIVE_PATH up /prefix/${pkgconfig_dir} /prefix)
  string(REGEX REPLACE "/$" "" pkgconfig_prefix "\${pcfiledir}/${up}")
endif()
set(pkgconfig_includedir "\${prefix}")
cmake_path(APPEND pkgconfig_includedir ${CMAKE_INSTALL_INCLUDEDIR}) # which may be absolute
configure_file(${CMAKE_CURRENT_LIST_DIR}/semiexplicit.pc.in ${PROJECT_BINARY_DIR}/semiexplicit.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/semiexplicit.pc DESTINATION ${pkgconfig_dir})

if(PROJECT_IS_TOP_LEVEL)
  add_custom_target(uninstall
    COMMAND ${CMAKE_COMMAND}
      -D MANIFEST=${PROJECT_BINARY_DIR}/install_manifest.txt -P ${CMAKE_CURRENT_LIST_DIR}/uninstall.cmake
    COMMENT "Removing the installed files"
    VERBATIM)
  include(${CMAKE_CURRENT_LIST_DIR}/packaging/cpack.cmake)
endif()
