/* io.h - registers of devices, 32 bits wide. The tests on the host put a model of a device in the place of io.c. */
#ifndef ZCU102_IO_H
#define ZCU102_IO_H

#include <stdint.h>

uint32_t zcu102_read(uint32_t address);
void zcu102_write(uint32_t address, uint32_t value);

#endif
