# Components, each of which cmake/Packages.cmake makes a package of: `command`, `mpi`, `vdb`, `library`, `development`, `python3`.
# Beside them is `python`, the package for a virtual environment (python/CMakeLists.txt).
include(CMakePackageConfigHelpers)

set(libraries ${CMAKE_INSTALL_LIBDIR}/metrolux)
install(TARGETS metrolux_command RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT command)
install(FILES ${METROLUX_SHELL_FOLDER}/metrolux.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT command)
install(FILES ${METROLUX_SHELL_FOLDER}/metrolux.bash RENAME metrolux
  DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT command)
install(FILES ${METROLUX_SHELL_FOLDER}/metrolux.zsh RENAME _metrolux
  DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions COMPONENT command)
install(FILES ${METROLUX_SHELL_FOLDER}/metrolux.fish
  DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d COMPONENT command)
if(TARGET metrolux_mpi)
  install(TARGETS metrolux_mpi LIBRARY DESTINATION ${libraries} COMPONENT mpi)
endif()
if(TARGET metrolux_vdb)
  install(TARGETS metrolux_vdb LIBRARY DESTINATION ${libraries} COMPONENT vdb)
endif()

install(TARGETS metrolux_library EXPORT MetroluxTargets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library
  NAMELINK_COMPONENT development)
foreach(level "" ${METROLUX_LEVELS})
  if(level)
    install(TARGETS metrolux_library-${level} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/glibc-hwcaps/${level}
      COMPONENT library NAMELINK_SKIP)
    install(TARGETS metrolux_command_library-${level} LIBRARY DESTINATION ${libraries}/glibc-hwcaps/${level} COMPONENT command)
  elseif(METROLUX_LEVELS)
    install(TARGETS metrolux_command_library LIBRARY DESTINATION ${libraries} COMPONENT command)
  endif()
endforeach()

# What a project needs that uses the library, and what leads it there (CMake, pkg-config).
install(DIRECTORY include/metrolux DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development FILES_MATCHING PATTERN "*.h")
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/Metrolux)
install(EXPORT MetroluxTargets NAMESPACE Metrolux:: DESTINATION ${package_dir} COMPONENT development)
configure_package_config_file(cmake/MetroluxConfig.cmake.in ${PROJECT_BINARY_DIR}/MetroluxConfig.cmake
  INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/MetroluxConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/MetroluxConfig.cmake ${PROJECT_BINARY_DIR}/MetroluxConfigVersion.cmake
  DESTINATION ${package_dir} COMPONENT development)

# The tree may be moved: the file says where its prefix is from where it is itself.
file(RELATIVE_PATH METROLUX_PREFIX_FROM_PC /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
configure_file(cmake/metrolux.pc.in ${PROJECT_BINARY_DIR}/metrolux.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/metrolux.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
