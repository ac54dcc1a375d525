# SPDX-License-Identifier: GPL-3.0-or-later
# The Debian package, by CPack: `./dev package`.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME ehad)
set(CPACK_PACKAGE_CONTACT "ehad developers <ehad@localhost>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
# The synopsis is the project's description.
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION
"A daemon and a command line for an electro-hydraulic actuator rig: they play
an excitation through a data acquisition card every millisecond, log what
moved, fit integer- and fractional-order transfer functions, and keep only
what passes validation. A simulated rig is included.")
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# systemd-sysusers creates the user. The package recommends gnuplot, and xlsx2csv for workbooks.
set(CPACK_DEBIAN_PACKAGE_DEPENDS "systemd | systemd-standalone-sysusers")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "gnuplot-nox, xlsx2csv")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "linux-image-rt-amd64")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA
  ${CMAKE_CURRENT_LIST_DIR}/postinst ${CMAKE_CURRENT_LIST_DIR}/prerm ${CMAKE_CURRENT_LIST_DIR}/postrm
  ${CMAKE_CURRENT_LIST_DIR}/conffiles)
# The component `debian` holds the files of the Debian package alone: a plain `cmake --install` writes neither to /etc nor
# Debian's own files.
set(CPACK_INSTALL_CMAKE_PROJECTS
  "${PROJECT_BINARY_DIR};${PROJECT_NAME};ALL;/"
  "${PROJECT_BINARY_DIR};${PROJECT_NAME};debian;/")
include(CPack)

set(documents ${PROJECT_BINARY_DIR}/debian)
configure_file(${CMAKE_CURRENT_LIST_DIR}/changelog.in ${documents}/changelog.Debian @ONLY)
# -n: without a time, so that the same source makes the same file
add_custom_command(OUTPUT ${documents}/changelog.gz ${documents}/changelog.Debian.gz
  COMMAND sh -c "gzip -9n < \"$1\" > changelog.gz && gzip -9n < changelog.Debian > changelog.Debian.gz" sh ${PROJECT_SOURCE_DIR}/CHANGELOG.md
  DEPENDS ${PROJECT_SOURCE_DIR}/CHANGELOG.md ${documents}/changelog.Debian
  WORKING_DIRECTORY ${documents}
  VERBATIM)
add_custom_target(debian_documents ALL DEPENDS ${documents}/changelog.gz ${documents}/changelog.Debian.gz)
add_custom_target(packaged DEPENDS eha eha-reader eha-safe eha-web eha-worker eha-hdf5 ehad completion manual debian_documents)
install(FILES ${PROJECT_SOURCE_DIR}/config/ehad.toml DESTINATION /etc/ehad COMPONENT debian EXCLUDE_FROM_ALL)
# Samples are where Debian users expect them.
file(CREATE_LINK ../../ehad ${documents}/examples SYMBOLIC)
install(FILES ${CMAKE_CURRENT_LIST_DIR}/copyright ${documents}/examples ${documents}/changelog.gz ${documents}/changelog.Debian.gz
  DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/ehad COMPONENT debian EXCLUDE_FROM_ALL)
install(FILES ${CMAKE_CURRENT_LIST_DIR}/lintian-overrides
  DESTINATION ${CMAKE_INSTALL_DATADIR}/lintian/overrides RENAME ehad COMPONENT debian EXCLUDE_FROM_ALL)
