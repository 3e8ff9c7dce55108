# Every third-party library, found in one place. All are Debian 12 packages (scripts/packages.txt).

# What our libraries link. The installed carat-config.cmake finds the same two lists again for its user.
set(CARAT_PACKAGES Threads fmt spdlog TBB hwy meshoptimizer GDAL OpenEXR OpenImageIO Vulkan nlohmann_json)
set(CARAT_PKGCONFIG_MODULES geographiclib libxxhash glm proj) # targets PkgConfig::GEOGRAPHICLIB, XXHASH, GLM, PROJ

include(CaratFind)
foreach(package IN LISTS CARAT_PACKAGES)
  carat_find_package(${package} REQUIRED)
endforeach()
carat_drop_missing_includes(OpenImageIO::OpenImageIO)
foreach(module IN LISTS CARAT_PKGCONFIG_MODULES)
  carat_pkg_check(${module} REQUIRED)
endforeach()

# What only this build needs.
find_package(CLI11 REQUIRED)
find_program(GLSLANG_VALIDATOR glslangValidator REQUIRED)
if(CARAT_BUILD_TESTS)
  find_package(GTest REQUIRED)
endif()
if(CARAT_BUILD_BENCH)
  find_package(benchmark REQUIRED)
endif()
