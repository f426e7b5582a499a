# Run by CPack on the tree that it packs: Debian wants the licence as /usr/share/doc/<package>/copyright.
if(CPACK_GENERATOR STREQUAL "DEB")
  set(doc "${CPACK_TEMPORARY_DIRECTORY}/usr/share/doc")
  file(RENAME "${doc}/semiexplicit" "${doc}/${CPACK_DEBIAN_PACKAGE_NAME}")
  file(RENAME "${doc}/${CPACK_DEBIAN_PACKAGE_NAME}/LICENSE" "${doc}/${CPACK_DEBIAN_PACKAGE_NAME}/copyright")
endif()
