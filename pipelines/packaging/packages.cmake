# Debian packages: acus (programs, presets, workflows), libacus-dev (the library), acus-doc (the web site).
# pipelines/packages makes manual pages, completion and site first, then calls cpack.

set(acus_made ${CMAKE_BINARY_DIR}/packages/made)
install(DIRECTORY ${acus_made}/man/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT desktop OPTIONAL)
install(DIRECTORY ${acus_made}/completion/ DESTINATION ${CMAKE_INSTALL_DATADIR} COMPONENT desktop OPTIONAL)
install(FILES ${CMAKE_CURRENT_LIST_DIR}/acus.desktop
        DESTINATION ${CMAKE_INSTALL_DATADIR}/applications COMPONENT desktop)
install(FILES ${CMAKE_CURRENT_LIST_DIR}/acus.svg
        DESTINATION ${CMAKE_INSTALL_DATADIR}/icons/hicolor/scalable/apps COMPONENT desktop)
install(DIRECTORY ${acus_made}/site/ DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/acus-doc/html
        COMPONENT documentation OPTIONAL)
# What Debian wants of each package. The changelog is compressed by pipelines/packages.
foreach(row "desktop acus" "library libacus-dev" "documentation acus-doc")
  separate_arguments(row)
  list(GET row 0 component)
  list(GET row 1 package)
  install(FILES ${CMAKE_CURRENT_LIST_DIR}/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package}
          COMPONENT ${component})
  install(DIRECTORY ${acus_made}/changelog/ DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package}
          COMPONENT ${component} OPTIONAL)
endforeach()
install(FILES ${CMAKE_CURRENT_LIST_DIR}/acus-doc.lintian-overrides
        DESTINATION ${CMAKE_INSTALL_DATADIR}/lintian/overrides RENAME acus-doc COMPONENT documentation)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME acus)
set(CPACK_PACKAGE_CONTACT "Acus maintainers <maintainers@acus.invalid>")
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
# Folders that others may list, whatever the umask of whoever builds.
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE
                                                WORLD_READ WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_ACUS_PACKAGE_NAME acus)
set(CPACK_DEBIAN_ACUS_PACKAGE_SECTION science)
set(CPACK_DEBIAN_ACUS_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_ACUS_PACKAGE_DEPENDS "python3, snakemake")
set(CPACK_DEBIAN_ACUS_PACKAGE_RECOMMENDS "libopenal1, zenity, xdg-utils, python3-tk")
set(CPACK_DEBIAN_ACUS_PACKAGE_SUGGESTS acus-doc)
set(CPACK_DEBIAN_ACUS_DESCRIPTION "Programs that prepare a patient from a CT, replay recorded device trajectories
through models of forces and ultrasound, run live sessions with haptic devices
and trackers, and compare the results.")
set(CPACK_DEBIAN_LIBACUS-DEV_PACKAGE_NAME libacus-dev)
set(CPACK_DEBIAN_LIBACUS-DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_LIBACUS-DEV_PACKAGE_DEPENDS "libeigen3-dev, nlohmann-json3-dev, libboost-dev, libssl-dev, \
libexpat1-dev, zlib1g-dev, libvalijson-dev, libinsighttoolkit5-dev, libvtk9-dev, libopencv-dev, libopencv-contrib-dev, \
libembree-dev, libtet1.5-dev, libavformat-dev, libavcodec-dev, libavutil-dev, libhdf5-dev, libmatio-dev, libpng-dev, libzip-dev, libbz2-dev, libsndfile1-dev, \
libopenigtlink-dev, libceres-dev, libhwy-dev, libsuitesparse-dev, libopenblas-dev, libcli11-dev, libx11-dev, qtbase5-dev, pkg-config")
set(CPACK_DEBIAN_LIBACUS-DEV_PACKAGE_RECOMMENDS acus)  # The presets.
set(CPACK_DEBIAN_LIBACUS-DEV_DESCRIPTION "Headers, static libraries and the files that find_package(Acus) reads: tissue,
needle, forces, ultrasound and breathing, to be built into other programs.")
set(CPACK_DEBIAN_ACUS-DOC_PACKAGE_NAME acus-doc)
set(CPACK_DEBIAN_ACUS-DOC_PACKAGE_SECTION doc)
set(CPACK_DEBIAN_ACUS-DOC_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_ACUS-DOC_DESCRIPTION "Tutorials, models with their equations, file formats and the reference of the
library, as a web site that opens from disk: /usr/share/doc/acus-doc/html.")

get_property(acus_programs GLOBAL PROPERTY ACUS_PROGRAMS)
set(CPACK_COMPONENTS_ALL ${acus_programs} Unspecified presets desktop library documentation)
include(CPack)
cpack_add_component_group(acus)
cpack_add_component_group(libacus-dev)
cpack_add_component_group(acus-doc)
foreach(component ${acus_programs} Unspecified presets desktop)
  cpack_add_component(${component} GROUP acus)
endforeach()
cpack_add_component(library GROUP libacus-dev)
cpack_add_component(documentation GROUP acus-doc)
