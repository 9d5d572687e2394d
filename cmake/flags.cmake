# The flags of all our C. Linking `tumble_flags` brings them.
add_library(tumble_flags INTERFACE)
if(NOT MSVC) # which fuses no products and sums unless it is told to, and has other warnings
  target_compile_options(tumble_flags INTERFACE
    -ffp-contract=off # host and target give the same bits
    -fno-math-errno # a square root is an instruction where there is one
    -Wall -Wextra -Wconversion -Wdouble-promotion -Wshadow -Wstrict-prototypes -Wvla -Werror)
endif()

# For code that is not ours but runs in our process (Unity, generated bindings): instrumented, not judged.
add_library(tumble_sanitizers INTERFACE)
if(TUMBLE_SANITIZE)
  set(sanitizers -fsanitize=address,undefined,float-divide-by-zero,float-cast-overflow -fno-sanitize-recover=all)
  target_compile_options(tumble_sanitizers INTERFACE ${sanitizers} -fno-omit-frame-pointer -O1)
  target_link_options(tumble_sanitizers INTERFACE ${sanitizers})
endif()
target_link_libraries(tumble_flags INTERFACE tumble_sanitizers)

# On a target whose stack is budgeted the compiler writes down its frames, which tools/budget checks against its own. And
# -Os is held to its word: what it still does for speed takes 0.4 kB of navcomp.
if(CMAKE_CROSSCOMPILING)
  set(TUMBLE_FRAMES -fstack-usage -fcallgraph-info=su,da)
  set(TUMBLE_SMALL -fno-tree-loop-im -fno-move-loop-invariants -fno-inline-functions-called-once
    -fno-thread-jumps -fno-schedule-insns2 -fno-tree-loop-ivcanon -fno-tree-dominator-opts)
  if(CMAKE_BUILD_TYPE STREQUAL MinSizeRel) # these make code longer at -Os
    list(APPEND TUMBLE_SMALL -fno-optimize-sibling-calls -fno-tree-switch-conversion -fno-caller-saves -fno-ipa-sra
      -fno-tree-pre -fno-partial-inlining)
  endif()
  target_compile_options(tumble_flags INTERFACE ${TUMBLE_FRAMES} ${TUMBLE_SMALL})
  # For the few lines that run with every sample: loops of three become straight code.
  set(TUMBLE_FAST -O2 -fpeel-loops)
endif()
