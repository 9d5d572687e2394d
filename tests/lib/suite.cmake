# The sources of a program of suites (suite.h): main, the list of the suites, and those given; a test_*.c with its cases
# listed.
function(tumble_suites program sources)
  set(declared)
  set(listed)
  set(taken)
  set(list_cases ${PROJECT_SOURCE_DIR}/tests/lib/suite_cases.cmake)
  foreach(source IN LISTS ARGN)
    cmake_path(ABSOLUTE_PATH source)
    if(source MATCHES "test_([a-z0-9_]+)\\.c$")
      set(name ${CMAKE_MATCH_1})
      string(APPEND declared "extern const suite_t suite_${name};\n")
      string(APPEND listed "&suite_${name}, ")
      set(suite ${CMAKE_CURRENT_BINARY_DIR}/${program}_${name}.c)
      add_custom_command(OUTPUT ${suite} DEPENDS ${source} ${list_cases}
        COMMAND ${CMAKE_COMMAND} -D NAME=${name} -D SOURCE=${source} -D OUT=${suite} -P ${list_cases} VERBATIM)
      set(source ${suite})
    endif()
    list(APPEND taken ${source})
  endforeach()
  set(list ${CMAKE_CURRENT_BINARY_DIR}/${program}_suites.c)
  file(CONFIGURE OUTPUT ${list} @ONLY
    CONTENT "#include \"suite.h\"\n\n@declared@\nconst suite_t *const suites[] = {@listed@NULL};\n")
  set(${sources} ${taken} ${list} ${PROJECT_SOURCE_DIR}/tests/lib/suite.c PARENT_SCOPE)
endfunction()

# A program of suites as a test. TEST_LIBRARIES of the calling folder is what it is linked with, TEST_LABELS how it is
# chosen (ctest -L).
function(tumble_test_program name)
  tumble_suites(${name} sources ${ARGN})
  add_executable(${name} ${sources})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests/lib)
  target_link_libraries(${name} PRIVATE tumble_flags ${TEST_LIBRARIES} unity m)
  add_test(NAME ${name} COMMAND ${name})
  set_tests_properties(${name} PROPERTIES TIMEOUT 300 LABELS "${TEST_LABELS}")
endfunction()
