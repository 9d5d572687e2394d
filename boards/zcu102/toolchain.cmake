# Bare metal on the Zynq UltraScale+ of the ZCU102 board: one Cortex-A53, 64 bits (QEMU: xlnx-zcu102).
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR cortex-a53)
set(TUMBLE_BOARD zcu102)

set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_ASM_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
# Without its MMU the processor takes memory for a device: no access may be unaligned. The C library of the compiler's
# packages is made for Linux; nothing of it is linked.
set(CMAKE_C_FLAGS_INIT "-mcpu=cortex-a53 -mstrict-align -fno-stack-protector -fno-pic -fno-pie")
string(APPEND CMAKE_C_FLAGS_INIT
  " -U_FORTIFY_SOURCE -fno-asynchronous-unwind-tables -ffunction-sections -fdata-sections")
set(CMAKE_ASM_FLAGS_INIT "-mcpu=cortex-a53")
set(CMAKE_EXE_LINKER_FLAGS_INIT "-static -nostdlib -nostartfiles -no-pie -Wl,--build-id=none")

set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
