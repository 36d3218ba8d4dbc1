# Debian packages, one for each component: `make packages`. Their dependencies on libraries are what dpkg-shlibdeps finds.
set(soversion ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME metrolux)
set(CPACK_PACKAGE_VENDOR Metrolux)
set(CPACK_PACKAGE_CONTACT "The Metrolux developers <metrolux@example.org>")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/src ${PROJECT_BINARY_DIR}/src/command)
set(CPACK_COMPONENTS_ALL)

function(metrolux_package component name section description)
  set(CPACK_COMPONENTS_ALL ${CPACK_COMPONENTS_ALL} ${component} PARENT_SCOPE)
  string(TOUPPER ${component} key)
  set(CPACK_DEBIAN_${key}_PACKAGE_NAME ${name} PARENT_SCOPE)
  set(CPACK_DEBIAN_${key}_PACKAGE_SECTION ${section} PARENT_SCOPE)
  set(CPACK_COMPONENT_${key}_DESCRIPTION "${description}" PARENT_SCOPE)
  install(FILES ${PROJECT_SOURCE_DIR}/THIRD-PARTY.md ${PROJECT_SOURCE_DIR}/CHANGELOG.md
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} COMPONENT ${component} EXCLUDE_FROM_ALL)
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE RENAME copyright
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} COMPONENT ${component} EXCLUDE_FROM_ALL)
endfunction()

metrolux_package(command metrolux graphics "physically based renderer (MCMC VCM)
 Renders Mitsuba, glTF and pbrt scenes with caustics, glass and indirect light.")
metrolux_package(library libmetrolux${soversion} libs "physically based renderer, shared library
 What programs load that render with Metrolux.")
metrolux_package(development libmetrolux-dev libdevel "physically based renderer, headers
 What programs that render with Metrolux are compiled with.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libmetrolux${soversion} (= ${PROJECT_VERSION})")
if(TARGET metrolux_mpi)
  metrolux_package(mpi metrolux-mpi graphics "physically based renderer, many machines
 What metrolux loads when MPI has started it.")
  set(CPACK_DEBIAN_MPI_PACKAGE_DEPENDS "metrolux (= ${PROJECT_VERSION})")
endif()
if(TARGET metrolux_vdb)
  metrolux_package(vdb metrolux-vdb graphics "physically based renderer, OpenVDB
 What metrolux loads for scenes with grids of OpenVDB.")
endif()
if(TARGET metrolux_python)
  math(EXPR Python3_NEXT_MINOR "${Python3_VERSION_MINOR} + 1")
  metrolux_package(python3 python3-metrolux python "physically based renderer, Python package
 Scenes, renderings and images as numpy arrays.")
  set(CPACK_DEBIAN_PYTHON3_PACKAGE_DEPENDS
    "libmetrolux${soversion} (= ${PROJECT_VERSION}), python3 (>= ${Python3_VERSION_MAJOR}.${Python3_VERSION_MINOR}), python3 (<< ${Python3_VERSION_MAJOR}.${Python3_NEXT_MINOR}), python3-numpy")
endif()
include(CPack)
