/* vectors.c - where a Cortex-M begins: its stack, and newlib's own start. */
#include <stdint.h>

void _start(void);
extern const uintptr_t vectors[2];
__attribute__((section(".vectors"))) const uintptr_t vectors[2] = {0x20400000, (uintptr_t)_start};
