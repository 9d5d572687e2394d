/* port.h - the board of this folder: two CAN nodes on one wire, a clock that is told how time passes, a memory. */
#ifndef MINE_PORT_H
#define MINE_PORT_H

#include "embed_board.h" /* board_memory */

#include <tumble/port.h>

#define MINE_QUEUE 64U /* frames that may wait; then the sender is told to wait */

extern const tumble_port_t mine_ports[2]; /* the first has the memory */

void mine_pass(void *context, uint32_t us);

#endif
