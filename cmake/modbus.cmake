# libmodbus, for the programs that talk Modbus: the target PkgConfig::MODBUS, if pkg-config finds it.
find_package(PkgConfig QUIET)
if(PkgConfig_FOUND)
  pkg_check_modules(MODBUS QUIET IMPORTED_TARGET libmodbus>=3.1.6)
endif()
