# How Carat finds a library; used by its own build and, installed, by carat-config.cmake.

# carat_find_package(name options...): find_package() without chatter. Debian's ImathTargets.cmake, which OpenEXR and
# OpenImageIO pull in, warns at length about a Python library that nobody here links; it does not heed QUIET.
macro(carat_find_package)
  set(_carat_log_level ${CMAKE_MESSAGE_LOG_LEVEL})
  set(CMAKE_MESSAGE_LOG_LEVEL NOTICE)
  find_package(${ARGV})
  set(CMAKE_MESSAGE_LOG_LEVEL ${_carat_log_level})
  unset(_carat_log_level)
endmacro()

# carat_drop_missing_includes(target): Debian's OpenImageIO::OpenImageIO names /usr/include/opencv4, which its package
# neither holds nor needs; CMake refuses a target with a folder that is not there.
function(carat_drop_missing_includes target)
  if(NOT TARGET ${target})
    return()
  endif()
  foreach(property IN ITEMS INTERFACE_INCLUDE_DIRECTORIES INTERFACE_SYSTEM_INCLUDE_DIRECTORIES)
    get_target_property(folders ${target} ${property})
    set(present "")
    foreach(folder IN LISTS folders)
      if(EXISTS "${folder}")
        list(APPEND present "${folder}")
      endif()
    endforeach()
    set_target_properties(${target} PROPERTIES ${property} "${present}")
  endforeach()
endfunction()

# carat_pkg_check(module options...): the imported target PkgConfig::<MODULE>, in capitals and without a leading "lib".
macro(carat_pkg_check module)
  find_package(PkgConfig QUIET ${ARGN})
  string(REGEX REPLACE "^lib" "" _carat_prefix ${module})
  string(TOUPPER ${_carat_prefix} _carat_prefix)
  if(NOT TARGET PkgConfig::${_carat_prefix})
    pkg_check_modules(${_carat_prefix} QUIET ${ARGN} IMPORTED_TARGET GLOBAL ${module})
  endif()
endmacro()
