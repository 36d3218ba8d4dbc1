# The command, the shared library with its headers, and what leads other projects to it (CMake, pkg-config).
include(CMakePackageConfigHelpers)

install(TARGETS metrolux_library EXPORT MetroluxTargets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
if(TARGET metrolux_command)
  install(TARGETS metrolux_command RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
if(TARGET metrolux_mpi)
  install(TARGETS metrolux_mpi LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/metrolux)
endif()
install(DIRECTORY include/metrolux DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/Metrolux)
install(EXPORT MetroluxTargets NAMESPACE Metrolux:: DESTINATION ${package_dir})
configure_package_config_file(cmake/MetroluxConfig.cmake.in ${PROJECT_BINARY_DIR}/MetroluxConfig.cmake
  INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/MetroluxConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/MetroluxConfig.cmake ${PROJECT_BINARY_DIR}/MetroluxConfigVersion.cmake
  DESTINATION ${package_dir})

# The tree may be moved: the file says where its prefix is from where it is itself.
file(RELATIVE_PATH METROLUX_PREFIX_FROM_PC /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
configure_file(cmake/metrolux.pc.in ${PROJECT_BINARY_DIR}/metrolux.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/metrolux.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
