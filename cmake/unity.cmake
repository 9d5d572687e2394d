# Unity, the unit test framework: its upstream release, or a copy that FETCHCONTENT_SOURCE_DIR_UNITY names. tools/setup
# leaves such a copy in build/unity where the network does not reach upstream.
include(FetchContent)

if(NOT FETCHCONTENT_SOURCE_DIR_UNITY AND EXISTS ${PROJECT_SOURCE_DIR}/build/unity/unity.c)
  set(FETCHCONTENT_SOURCE_DIR_UNITY ${PROJECT_SOURCE_DIR}/build/unity)
endif()

FetchContent_Declare(unity
  URL https://github.com/ThrowTheSwitch/Unity/archive/refs/tags/v2.5.2.tar.gz
  URL_HASH SHA256=3786de6c8f389be3894feae4f7d8680a02e70ed4dbcce36109c8f8646da2671a
  SOURCE_SUBDIR not-its-own-build) # only its sources are used
FetchContent_MakeAvailable(unity)

find_path(TUMBLE_UNITY_DIR unity.c PATHS ${unity_SOURCE_DIR} PATH_SUFFIXES src NO_DEFAULT_PATH REQUIRED)
add_library(unity STATIC ${TUMBLE_UNITY_DIR}/unity.c)
target_include_directories(unity SYSTEM PUBLIC ${TUMBLE_UNITY_DIR})
target_compile_definitions(unity PUBLIC UNITY_INCLUDE_DOUBLE PRIVATE UNITY_DETAIL1_NAME="row") # see ROW
target_link_libraries(unity PUBLIC tumble_sanitizers)
