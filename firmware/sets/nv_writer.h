/* nv_writer.h - one erase or one program of the non-volatile memory, read back afterwards (private to the room).
 *
 * Begin, then step until it is done; a step makes at most one call of the memory. The bytes to be programmed must stay
 * where they are until then.
 */
#ifndef TUMBLE_SETS_NV_WRITER_H
#define TUMBLE_SETS_NV_WRITER_H

#include "tumble/sets.h"

void tumble_nv_writer_init(tumble_nv_writer_t *writer, const tumble_nv_t *nv);

/* The same if all regions have room there, else nothing. Returns what tumble_regions_check says. */
tumble_status_t tumble_nv_writer_open(tumble_nv_writer_t *writer, const tumble_nv_t *nv);

/* Erase the sector at `offset`; its first `size` bytes must be blank then. Sizes are multiples of
 * TUMBLE_NV_MAX_GRANULE. */
void tumble_nv_begin_erase(tumble_nv_writer_t *writer, uint32_t offset, uint32_t size);

/* Program `bytes`; the memory must hold them afterwards. */
void tumble_nv_begin_program(tumble_nv_writer_t *writer, uint32_t offset, const uint8_t *bytes, uint32_t size);

/* Only check that `size` bytes are blank. */
void tumble_nv_begin_blank(tumble_nv_writer_t *writer, uint32_t offset, uint32_t size);

/* Returns TUMBLE_E_PORT_BUSY (step again), TUMBLE_OK, or TUMBLE_E_NV (a call failed, or what is read back differs). */
tumble_status_t tumble_nv_writer_step(tumble_nv_writer_t *writer);

/* One read; whatever a port answers beyond TUMBLE_OK and TUMBLE_E_PORT_BUSY becomes TUMBLE_E_NV. */
tumble_status_t tumble_nv_read(const tumble_nv_t *nv, uint32_t offset, uint8_t *bytes, uint32_t size);

bool tumble_nv_is_blank(const uint8_t *bytes, uint32_t size);

#endif
