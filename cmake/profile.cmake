# tumble-bench from a profile, in two builds in one folder (CONTRIBUTING.md): TUMBLE_PROFILE=generate counts where runs
# spend their time when the target `profile` is built, TUMBLE_PROFILE=use compiles by the counts, which lie beside the
# objects. Where it goes inline and what it lays out first is all that changes, no arithmetic: the bytes of the output
# stay (tests/integration/test_profile.py).
if(NOT TUMBLE_PROFILE)
  return()
endif()
if(NOT CMAKE_C_COMPILER_ID STREQUAL "GNU")
  message(FATAL_ERROR "TUMBLE_PROFILE needs gcc: clang keeps its counts in another way")
endif()
if(TUMBLE_PROFILE STREQUAL "generate")
  target_compile_options(tumble-bench PRIVATE -fprofile-generate)
  target_link_options(tumble-bench PRIVATE -fprofile-generate)
  # Plain runs, and few hostile lives, or what these alone need would be taken for code that never runs.
  add_custom_target(profile
    COMMAND find ${CMAKE_CURRENT_BINARY_DIR} -name *.gcda -delete
    COMMAND tumble-bench --runs 60 --means --jobs 1 --seed 1000000 > profile-runs.txt
    COMMAND tumble-bench --campaign 4 --jobs 1 > profile-lives.txt
    DEPENDS tumble-bench
    VERBATIM)
elseif(TUMBLE_PROFILE STREQUAL "use")
  target_compile_options(tumble-bench PRIVATE -fprofile-use -fno-tree-vectorize -Wno-missing-profile)
  target_link_options(tumble-bench PRIVATE -fprofile-use)
else()
  message(FATAL_ERROR "TUMBLE_PROFILE is generate, use or empty, not ${TUMBLE_PROFILE}")
endif()
