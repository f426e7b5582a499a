# `cpack -G DEB` in a build tree makes a Debian package of what is installed, `cpack -G TGZ` an archive.
set(CPACK_PACKAGE_NAME semiexplicit)
set(CPACK_PACKAGE_VENDOR "The semiexplicit authors")
set(CPACK_PACKAGE_CONTACT "The semiexplicit authors <semiexplicit@localhost>"
  CACHE STRING "Who answers for a package made here, with an address")
set(CPACK_PACKAGE_DESCRIPTION
"The semiexplicit method of Jayawardana and Ohsawa: phase space doubled,
explicit kicks of any order, symmetric projection. Symplectic and reversible
also where the Hamiltonian is not a kinetic energy plus a potential. C++20
headers only.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)

set(CPACK_DEBIAN_PACKAGE_NAME libsemiexplicit-dev)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "libeigen3-dev (>= ${SEMIEXPLICIT_MINIMUM_EIGEN})")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "libboost-dev, pkg-config")
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/debian_licence.cmake)
include(CPack)
