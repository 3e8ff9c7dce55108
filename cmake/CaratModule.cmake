# carat_module(NAME module SOURCES ... [DEPENDS carat modules ...] [LINK public libraries ...] [PRIVATE_LINK ...])
#
# One static library a module, alias carat::<name>. Headers live in include/carat/<name>/ of the module's
# directory and are visible only to targets that link it: that is how the build enforces who may include whom.
# The test house.include_arrows checks the same table against the #include lines themselves.

set(CARAT_ALLOWED_globe "")
set(CARAT_ALLOWED_codec "globe")
set(CARAT_ALLOWED_preprocess "globe;codec")
set(CARAT_ALLOWED_render "globe;codec")
set(CARAT_ALLOWED_vulkan "render;globe")
set(CARAT_ALLOWED_synth "globe")
set(CARAT_ALLOWED_bench "globe;codec;preprocess;render;synth")

function(carat_flags target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
    $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
    $<$<BOOL:${CARAT_WERROR}>:-Werror>)
  # Contraction off everywhere, in users' code too: a fused multiply-add would give a shared vertex two positions.
  target_compile_options(${target} PUBLIC -ffp-contract=off)
  if(CARAT_SANITIZE)
    target_compile_options(${target} PUBLIC -fsanitize=${CARAT_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
    target_link_options(${target} PUBLIC -fsanitize=${CARAT_SANITIZE})
  endif()
endfunction()

function(carat_module)
  cmake_parse_arguments(M "" "NAME" "SOURCES;DEPENDS;LINK;PRIVATE_LINK" ${ARGN})
  if(NOT DEFINED CARAT_ALLOWED_${M_NAME})
    message(FATAL_ERROR "No module '${M_NAME}' in the table CARAT_ALLOWED_* of CaratModule.cmake")
  endif()
  foreach(dep IN LISTS M_DEPENDS)
    if(NOT dep IN_LIST CARAT_ALLOWED_${M_NAME})
      message(FATAL_ERROR "carat_${M_NAME} may not depend on carat_${dep}: see CARAT_ALLOWED_* in CaratModule.cmake")
    endif()
  endforeach()
  set(lib carat_${M_NAME})
  add_library(${lib} STATIC ${M_SOURCES})
  add_library(carat::${M_NAME} ALIAS ${lib})
  set_target_properties(${lib} PROPERTIES EXPORT_NAME ${M_NAME})
  carat_flags(${lib})
  target_include_directories(${lib} PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}> PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/src)
  list(TRANSFORM M_DEPENDS PREPEND carat::)
  target_link_libraries(${lib} PUBLIC ${M_DEPENDS} ${M_LINK} PRIVATE ${M_PRIVATE_LINK})
  install(TARGETS ${lib} EXPORT carat-targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(DIRECTORY include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.hpp")
  set_property(GLOBAL APPEND PROPERTY CARAT_MODULES ${M_NAME})
endfunction()
