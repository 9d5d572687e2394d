# What `cmake --install` puts where, for find_package(tumble) and for pkg-config. The headers of the rooms, which
# tumble::navcomp needs, stand apart from those that a user includes.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/tumble)
set(headers ${CMAKE_INSTALL_INCLUDEDIR})
set(headers_of_rooms ${headers}/tumble/rooms)

install(TARGETS tumble_core EXPORT tumble INCLUDES DESTINATION ${headers})
install(TARGETS tumble_navcomp EXPORT tumble INCLUDES DESTINATION ${headers_of_rooms})
install(DIRECTORY include/tumble DESTINATION ${headers})
install(DIRECTORY canopen core navcomp procedure sample sets stand DESTINATION ${headers_of_rooms}
  FILES_MATCHING PATTERN *.h)
install(EXPORT tumble FILE tumble-config.cmake NAMESPACE tumble:: DESTINATION ${package})

# Before 1.0 a minor number may break what was there.
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/tumble-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/tumble-config-version.cmake DESTINATION ${package})

file(RELATIVE_PATH up ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX}) # the prefix may move
string(REGEX REPLACE "/$" "" up ${up})
foreach(name tumble-core tumble)
  configure_file(${name}.pc.in ${name}.pc @ONLY)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endforeach()

# The licence stands in the repository's root. A copy of this folder has it within or beside it, where the licence of
# somebody else may stand, too: the notice tells.
foreach(folder ${CMAKE_CURRENT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR}/..)
  set(notice "")
  if(EXISTS ${folder}/LICENSE AND EXISTS ${folder}/NOTICE)
    file(STRINGS ${folder}/NOTICE notice LIMIT_COUNT 1)
  endif()
  if(notice STREQUAL "Tumble")
    install(FILES ${folder}/LICENSE ${folder}/NOTICE DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/tumble)
    break()
  endif()
endforeach()
