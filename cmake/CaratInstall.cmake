# cmake --install gives the program, the libraries, the headers and what find_package(carat) needs.
include(CMakePackageConfigHelpers)
set(carat_config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/carat)
get_property(CARAT_MODULES GLOBAL PROPERTY CARAT_MODULES)

configure_package_config_file(cmake/carat-config.cmake.in carat-config.cmake INSTALL_DESTINATION ${carat_config_dir})
# Until 1.0 a new minor version may change interfaces.
write_basic_package_version_file(carat-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/carat-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/carat-config-version.cmake
  cmake/CaratFind.cmake DESTINATION ${carat_config_dir})
if(CARAT_MODULES)
  install(EXPORT carat-targets NAMESPACE carat:: DESTINATION ${carat_config_dir})
endif()
install(FILES LICENSE README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
