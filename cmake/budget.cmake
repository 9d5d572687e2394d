find_package(Python3 REQUIRED COMPONENTS Interpreter)

# The parts that are measured, by their sources, which tumble::core and tumble::navcomp hold among others.
set(part_optimal core/crc32.c core/gain_record.c core/optimal.c core/turn.c)
set(part_inclined core/inclined.c)
set(part_inclined_uncertainty core/uncertainty_inclined.c)
set(part_whole_model core/triangle.c core/whole_model.c core/whole_place.c core/whole_run.c)
set(part_uncertainty core/uncertainty.c core/uncertainty_gains.c core/stand_record.c)
set(part_worst_norm core/worst_norm.c)
set(part_misfit core/misfit.c)
set(part_blocks core/blocks.c)
set(part_noise core/noise.c)
set(part_chi_squared core/chi_squared.c)
set(part_stand_seen core/stand_fit.c core/stand_seen.c core/triangle.c)
set(part_schedules core/schedules.c)
set(part_thermal core/thermal.c)
set(part_thermal_sets sets/thermal_record.c sets/thermal_rules.c)
set(part_navcomp_uncertainty navcomp/uncertainty.c)
foreach(room core sets sample canopen stand procedure navcomp)
  set(folder ${PROJECT_SOURCE_DIR}/firmware)
  file(GLOB part_${room} CONFIGURE_DEPENDS RELATIVE ${folder} ${folder}/${room}/*.c ${folder}/${room}/*/*.c)
endforeach()
list(REMOVE_ITEM part_core ${part_optimal} ${part_inclined} ${part_uncertainty} ${part_worst_norm} ${part_misfit} ${part_stand_seen} ${part_schedules}
  ${part_whole_model} ${part_blocks} ${part_noise} ${part_chi_squared} core/optimal_uncertainty.c
  ${part_inclined_uncertainty} ${part_thermal})
list(REMOVE_ITEM part_sets ${part_thermal_sets})
set(part_keeper ${part_navcomp})
list(FILTER part_keeper INCLUDE REGEX "/(keeper[a-z_]*|fingerprint|parameters)\\.c$")
list(REMOVE_ITEM part_navcomp ${part_keeper} ${part_navcomp_uncertainty} navcomp/views.c)

# The objects of parts, out of those of the libraries.
function(tumble_part_objects objects)
  set(found)
  foreach(part IN LISTS ARGN)
    list(JOIN part_${part} "|" sources)
    set(library tumble_navcomp)
    if(sources MATCHES "^(core|sets)/")
      set(library tumble_core)
    endif()
    list(APPEND found $<FILTER:$<TARGET_OBJECTS:${library}>,INCLUDE,/\(${sources}\)[.]o>)
  endforeach()
  set(${objects} ${found} PARENT_SCOPE)
endfunction()

# The sources of a part or of a library once more, for a link that optimises the whole.
function(tumble_for_the_whole library)
  if(NOT TARGET ${library}_for_the_whole)
    if(TARGET ${library})
      get_target_property(sources ${library} SOURCES)
      get_target_property(directory ${library} SOURCE_DIR)
    else()
      set(sources ${part_${library}})
      set(directory ${PROJECT_SOURCE_DIR}/firmware)
    endif()
    list(TRANSFORM sources PREPEND ${directory}/ REGEX "^[^/]")
    add_library(${library}_for_the_whole OBJECT EXCLUDE_FROM_ALL ${sources})
    foreach(source IN LISTS sources) # what is set for a source holds in one directory alone
      get_property(options SOURCE ${source} DIRECTORY ${directory} PROPERTY COMPILE_OPTIONS)
      set_property(SOURCE ${source} PROPERTY COMPILE_OPTIONS ${options})
    endforeach()
    target_include_directories(${library}_for_the_whole PRIVATE ${PROJECT_SOURCE_DIR}/firmware
    ${PROJECT_SOURCE_DIR}/firmware/include)
    target_compile_options(${library}_for_the_whole PRIVATE -flto)
    target_link_libraries(${library}_for_the_whole PRIVATE tumble_flags)
  endif()
endfunction()

# Hold parts, and LIBRARIES beside them, to a row of boards/budget.csv, as part of the build: they are linked with what
# they keep in RAM, and measured. They are linked whole, or with ROOTS what these symbols need of them. CALLS lists where
# indirect calls lead (tools/footprint/calls.py); without it there must be none. With ROOTS the link optimises the whole,
# and what it makes of the objects is measured. INTEGER are functions that may reach no floating point. The target is
# budget_<name>.
#
#   tumble_budget(<name> ROW <part in the table> PARTS <parts> [LIBRARIES <targets>] [RESIDENT <sources>]
#                 [ROOTS <symbols>] [CALLS <file>] [INTEGER <functions>] [ON_DEMAND])
function(tumble_budget name)
  cmake_parse_arguments(arg "ON_DEMAND" "ROW;CALLS" "PARTS;LIBRARIES;RESIDENT;ROOTS;INTEGER" ${ARGN})
  tumble_part_objects(objects ${arg_PARTS})
  foreach(library IN LISTS arg_LIBRARIES)
    list(APPEND objects $<TARGET_OBJECTS:${library}>)
  endforeach()
  set(linked_objects ${objects})
  if(arg_ROOTS)
    set(linked_objects)
    foreach(library IN LISTS arg_PARTS arg_LIBRARIES)
      tumble_for_the_whole(${library})
      list(APPEND linked_objects $<TARGET_OBJECTS:${library}_for_the_whole>)
    endforeach()
  endif()
  set(image footprint_${name})
  add_executable(${image} EXCLUDE_FROM_ALL ${linked_objects} ${arg_RESIDENT})
  target_include_directories(${image} PRIVATE ${PROJECT_SOURCE_DIR}/firmware
    ${PROJECT_SOURCE_DIR}/firmware/include)
  target_link_options(${image} PRIVATE -nostdlib LINKER:--entry=0 LINKER:-Map=$<TARGET_FILE:${image}>.map
    LINKER:--sort-section=alignment)
  target_link_libraries(${image} PRIVATE tumble_flags -Wl,--start-group gcc c m nosys -Wl,--end-group)

  set(more)
  if(arg_ROOTS)
    list(TRANSFORM arg_ROOTS PREPEND LINKER:--require-defined= OUTPUT_VARIABLE roots)
    target_link_options(${image} PRIVATE LINKER:--gc-sections ${roots}
      -flto -flto-partition=one -save-temps ${TUMBLE_FRAMES} ${TUMBLE_SMALL})
    add_dependencies(${image} tumble_core tumble_navcomp ${arg_LIBRARIES}) # whose objects say what is imported
    set(more LINKED $<TARGET_FILE:${image}>.ltrans0.ltrans.o)
  endif()
  if(arg_CALLS)
    list(APPEND more CALLS ${arg_CALLS})
  endif()
  if(arg_ON_DEMAND)
    list(APPEND more ON_DEMAND)
  endif()
  tumble_hold_to_row(${name} ROW ${arg_ROW} IMAGE ${image} OBJECTS ${objects} INTEGER ${arg_INTEGER} ${more})
endfunction()

# The same for a whole image, as it is flown, and linked with a map beside it. OBJECTS are all that it is made of;
# EXCEPTIONS is the label of its table of exceptions. The target is budget_<name>.
#
#   tumble_hold_to_row(<name> ROW <part in the table> IMAGE <target> OBJECTS <files> EXCEPTIONS <label>
#                      [CALLS <file>] [INTEGER <functions>] [ON_DEMAND])
function(tumble_hold_to_row name)
  cmake_parse_arguments(arg "ON_DEMAND" "ROW;IMAGE;CALLS;LINKED;EXCEPTIONS" "OBJECTS;INTEGER" ${ARGN})
  set(all ALL)
  if(arg_ON_DEMAND)
    set(all)
  endif()
  set(options)
  foreach(option CALLS LINKED EXCEPTIONS)
    if(arg_${option})
      string(TOLOWER --${option} spelt)
      list(APPEND options ${spelt} ${arg_${option}})
    endif()
  endforeach()
  foreach(function IN LISTS arg_INTEGER)
    list(APPEND options --integer ${function})
  endforeach()
  if(arg_CALLS)
    target_link_options(${arg_IMAGE} PRIVATE LINKER:--emit-relocs)
  endif()
  set(object_list ${CMAKE_CURRENT_BINARY_DIR}/${name}.objects)
  file(GENERATE OUTPUT ${object_list} CONTENT "$<JOIN:${arg_OBJECTS},\n>\n")
  string(REGEX REPLACE "objdump$" "" tools ${CMAKE_OBJDUMP})

  add_custom_target(budget_${name} ${all}
    COMMAND ${Python3_EXECUTABLE} -B ${PROJECT_SOURCE_DIR}/tools/budget
      --limits ${PROJECT_SOURCE_DIR}/boards/budget.csv --target ${CMAKE_SYSTEM_PROCESSOR} --part ${arg_ROW}
      --tools ${tools} --image $<TARGET_FILE:${arg_IMAGE}> --map $<TARGET_FILE:${arg_IMAGE}>.map ${options}
      --out ${CMAKE_CURRENT_BINARY_DIR}/budget_${name}.csv @${object_list}
    DEPENDS ${arg_IMAGE} ${arg_CALLS} VERBATIM)
endfunction()
