/* stand_operator.h - the simulated operator of a stand whose firmware runs elsewhere.
 *
 * He reads the state PDO of node 1 and answers by SDO: puts the block on the table as asked and confirms it, mends what
 * the scenario lets him mend, and, if told to, gives the command to start. So it is the same to him whether node 1 is a
 * process of Linux, an emulated board or a real one.
 */
#ifndef TUMBLE_LINUX_STAND_OPERATOR_H
#define TUMBLE_LINUX_STAND_OPERATOR_H

#include "bench/world.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    bool mounts;
    bool starts;

    bench_question_t question; /* open at the moment */
    uint64_t act_us;           /* when he does something about it; SIM_NEVER: not at all */
    uint8_t command;           /* under way by SDO; 0: none */
    uint8_t argument;
    bool argued;               /* the argument has been taken */
    uint64_t patience_us;      /* until then he waits for the answer to an SDO request */
    uint32_t answers;          /* commands accepted */
    uint32_t refusals;
} stand_operator_t;

void stand_operator_init(stand_operator_t *operator, bool mounts, bool starts);

/* A frame has gone over the bus: the state PDO, or an answer to a request. */
void stand_operator_hear(stand_operator_t *operator, bench_world_t *world, const tumble_can_frame_t *frame);

/* When he wants to be looked at again. */
uint64_t stand_operator_next_us(const stand_operator_t *operator);

/* His time may have come. */
void stand_operator_step(stand_operator_t *operator, bench_world_t *world);

#endif
