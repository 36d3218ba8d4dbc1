include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

get_property(modules GLOBAL PROPERTY METROLUX_MODULES)
install(TARGETS metrolux metrolux_options ${modules} EXPORT MetroluxTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
if(TARGET metrolux_command)
  install(TARGETS metrolux_command RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
install(DIRECTORY src/ DESTINATION include/metrolux FILES_MATCHING PATTERN "*.h")
install(EXPORT MetroluxTargets NAMESPACE Metrolux:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/Metrolux)
configure_package_config_file(cmake/MetroluxConfig.cmake.in ${PROJECT_BINARY_DIR}/MetroluxConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/Metrolux)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/MetroluxConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/MetroluxConfig.cmake ${PROJECT_BINARY_DIR}/MetroluxConfigVersion.cmake
  ${PROJECT_SOURCE_DIR}/cmake/Dependencies.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/Metrolux)
