/* nv_memory.h - a stand-in for the board's flash: memory that behaves like it (tumble/port.h), as long as power is on.
 *
 * The chip's own flash (QSPI) is not driven. In the emulator a file can be loaded to where this memory lies, so that a
 * run finds there what an earlier one might have left; what it leaves itself is gone with the emulator. On the chip,
 * where memory has any values at power-on, the board states no non-volatile memory at all.
 *
 * A granule that is not erased is not programmed: TUMBLE_E_NV. Operations end at once.
 */
#ifndef ZCU102_NV_MEMORY_H
#define ZCU102_NV_MEMORY_H

#include "tumble/port.h"

#include <stdint.h>

#define ZCU102_NV_SECTOR 4096U
#define ZCU102_NV_GRANULE 8U
#define ZCU102_NV_SECTORS 16U
#define ZCU102_NV_BYTES (ZCU102_NV_SECTOR * ZCU102_NV_SECTORS)

/* Take ZCU102_NV_BYTES at `memory`, which outlive the result. Where nothing was loaded the emulator's memory is zero,
 * what no flash with anything in it is: it is erased then. */
tumble_nv_t zcu102_nv_memory(uint8_t *memory);

#endif
