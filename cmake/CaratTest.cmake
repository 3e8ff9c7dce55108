# carat_test(name SOURCES files ... LINK libraries ... [LABELS more ...] [TIMEOUT seconds of each TEST, default 600])
#
# One GoogleTest executable; every TEST in it is a ctest of its own, named <name>.<Suite>.<Test>, run in a process of its
# own, and shown by ctest as skipped when it calls GTEST_SKIP(). The tests are asked for when ctest starts, so a
# target that was not built costs one NOT_BUILT line and no more.
#
# Labels, for ctest -L: the folders under tests/ (globe; render and cut; ...) and the kinds of evidence that the files' names state,
# x_fuzz_test.cpp -> fuzz. The targets tests-<label> build what carries that label.
include(GoogleTest)

function(carat_test name)
  cmake_parse_arguments(T "" "TIMEOUT" "SOURCES;LINK;LABELS" ${ARGN})
  if(NOT T_TIMEOUT)
    set(T_TIMEOUT 600)
  endif()
  add_executable(${name} ${T_SOURCES})
  carat_flags(${name})
  target_link_libraries(${name} PRIVATE ${T_LINK} GTest::gtest GTest::gtest_main)
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  target_compile_definitions(${name} PRIVATE CARAT_SOURCE_DIR="${PROJECT_SOURCE_DIR}")

  carat_test_labels(labels ${T_SOURCES})
  list(APPEND labels ${T_LABELS})
  foreach(label IN LISTS labels)
    if(NOT TARGET tests-${label})
      add_custom_target(tests-${label})
    endif()
    add_dependencies(tests-${label} ${name})
  endforeach()

  gtest_discover_tests(${name} TEST_PREFIX ${name}. TEST_LIST ${name}_TESTS NO_PRETTY_VALUES
    DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT ${T_TIMEOUT})
  # gtest_discover_tests() takes no list as a property's value; ctest reads this file after the one with the tests.
  set(label_file ${CMAKE_CURRENT_BINARY_DIR}/${name}_labels.cmake)
  file(WRITE ${label_file}
    "if(${name}_TESTS)\n  set_tests_properties(\${${name}_TESTS} PROPERTIES LABELS \"${labels}\")\nendif()\n")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${label_file})
endfunction()

# carat_test_labels(out sources ...): the folders' names and the kinds named in x_<kind>_test.cpp.
function(carat_test_labels out)
  file(RELATIVE_PATH labels ${PROJECT_SOURCE_DIR}/tests ${CMAKE_CURRENT_SOURCE_DIR})
  string(REPLACE "/" ";" labels ${labels})
  foreach(source IN LISTS ARGN)
    if(source MATCHES "_(unit|property|golden|fuzz|accuracy|image)_test\\.cpp$")
      list(APPEND labels ${CMAKE_MATCH_1})
    endif()
  endforeach()
  list(REMOVE_DUPLICATES labels)
  set(${out} ${labels} PARENT_SCOPE)
endfunction()
