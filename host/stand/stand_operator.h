/* stand_operator.h - the operator of a simulated stand whose firmware runs elsewhere.
 *
 * He reads the state PDO of node 1 and answers by SDO, through its second server, so that he does not disturb scripts on
 * the first; through the first one, where that alone answers: puts the block on the table as asked and confirms it, mends what
 * the scenario lets him mend, and, if told to, gives the command to start. Or he does nothing by himself: a person says
 * when it is done, and what is to be done after a fault. Or he lends his hands alone and sends nothing: the script or
 * PLC that is tried talks to node 1, and he has mounted before it can, or the moment that it confirms. So it is the same to him whether node 1 is a process of Linux, an emulated board
 * or a real one.
 */
#ifndef TUMBLE_STAND_STAND_OPERATOR_H
#define TUMBLE_STAND_STAND_OPERATOR_H

#include "world/world.h"

#include <stdbool.h>
#include <stdint.h>

/* What the operator does by himself. */
typedef enum {
    STAND_OPERATOR_NONE = 0, /* nothing */
    STAND_OPERATOR_MOUNTS,   /* answers node 1 */
    STAND_OPERATOR_STARTS,   /* likewise, and gives the command to start, once */
    STAND_OPERATOR_ASKS,     /* what a person tells him */
    STAND_OPERATOR_HANDS,    /* mounts and mends at once; others tell node 1 */
    STAND_OPERATOR_FOLLOWS   /* mounts when others have confirmed, mends when they let node 1 go on */
} stand_operator_kind_t;

typedef struct {
    stand_operator_kind_t kind;
    bool starts; /* still has to */

    bench_question_t question; /* open at the moment */
    uint64_t act_us;           /* when he does something about it; SIM_NEVER: not at all */
    uint8_t command;           /* under way by SDO; 0: none */
    uint8_t argument;
    bool argued;          /* the argument has been taken */
    bool refused;         /* an answer came */
    uint16_t below;       /* by how much identifiers are lower than those of the first SDO server: it is the second */
    uint64_t patience_us; /* until then he waits for the answer to an SDO request */
    uint64_t early_us;    /* until then a "done" counts that came before its question was heard */
    uint32_t answers;     /* commands accepted */
    uint32_t refusals;
} stand_operator_t;

void stand_operator_init(stand_operator_t *operator, stand_operator_kind_t kind);

/* What the person says: "done" (mounted, or mended: go on), "abort", "repeat position INDEX", "repeat mounting NUMBER".
 * Who is told by node 1 itself may be faster than the bus: a "done" without a question waits two seconds for one.
 * False: it is none of that, or nobody is to be asked. What node 1 refuses is not tried again: the person
 * may say something else. */
bool stand_operator_answer(stand_operator_t *operator, bench_world_t *world, const char *line);

/* A frame has gone over the bus: the state PDO, or an answer to a request. */
void stand_operator_hear(stand_operator_t *operator, bench_world_t *world, const tumble_can_frame_t *frame);

/* When he wants to be looked at again. */
uint64_t stand_operator_next_us(const stand_operator_t *operator);

/* His time may have come. */
void stand_operator_step(stand_operator_t *operator, bench_world_t *world);

#endif
