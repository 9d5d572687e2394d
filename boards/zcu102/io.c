#include "io.h"

uint32_t zcu102_read(uint32_t address)
{
    return *(volatile uint32_t *)(uintptr_t)address;
}

void zcu102_write(uint32_t address, uint32_t value)
{
    *(volatile uint32_t *)(uintptr_t)address = value;
}
