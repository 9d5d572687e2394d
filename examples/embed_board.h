/* embed_board.h - what examples/embed.c needs of its board: samples and a memory. embed_board.c plays both. */
#ifndef EMBED_BOARD_H
#define EMBED_BOARD_H

#include "tumble/core.h"
#include "tumble/port.h"

/* The next sample at this position (its index in tumble_schedule_paper); valid until the next call. */
const tumble_sample_t *board_sample(uint8_t position);

/* The non-volatile memory. */
extern const tumble_nv_t board_memory;

#endif
