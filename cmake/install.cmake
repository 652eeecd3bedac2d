# cmake --install: the program, the library, its headers, and find_package(pointbake) -> pointbake::pointbake.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

install(TARGETS pointbake_cli)
install(TARGETS pointbake EXPORT pointbake-targets)
install(DIRECTORY include/pointbake DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(EXPORT pointbake-targets NAMESPACE pointbake::
    DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/pointbake)
configure_package_config_file(cmake/pointbake-config.cmake.in
    ${CMAKE_CURRENT_BINARY_DIR}/pointbake-config.cmake
    INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/pointbake)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/pointbake-config-version.cmake
    COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/pointbake-config.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/pointbake-config-version.cmake
    DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/pointbake)
