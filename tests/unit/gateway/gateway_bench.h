/* gateway_bench.h - the gateway's poller and a node that a test plays, on a clock that it holds.
 *
 * The node refuses all objects but 2020h:1, a REAL64 (`k_xx`), 2000h, which is 5, and those that the test gives it; it
 * takes all writes, and remembers the last ones. It has both SDO servers, and answers on the one that is asked.
 */
#ifndef TUMBLE_TESTS_GATEWAY_BENCH_H
#define TUMBLE_TESTS_GATEWAY_BENCH_H

#include "core/bytes.h"
#include "fake_port.h"
#include "played_sdo.h"
#include "session.h"
#include "support.h"

#include <string.h>

#define NODE 9U
#define PERIOD_US 1000000U
#define NO_DATA 0x08000024U
#define BUSY_NOW 0x08000022U
#define STEPS_OF_A_POLL 100000

typedef struct {
    fake_port_t fake;
    gateway_t gateway; /* which allows commands; to tests that have no sessions only its poller matters */
    played_sdo_t sdo;  /* with one server 1201h is refused */
    double k_xx;       /* what 2020h:1 reads as; 0: refused */
    unsigned looks;    /* reads of 1201h:1 */
    unsigned reads;
    unsigned busy_at;    /* this read of 2020h:1, from 1 on, is refused: its memory is at work; 0: none */
    unsigned tear_at;    /* so many reads from now on k_xx changes; 0: never */
    uint32_t refuse;     /* of writes */
    uint32_t abort_next; /* of the next read */
    played_object_t writes[64];
    unsigned written;
    unsigned event_at; /* so many reads from now on `event` happens, before the answer; 0: never */
    void (*event)(void);
    void (*on_write)(void); /* null: nothing; `last_write` is what was written */
} bench_t;

extern bench_t bench;

void bench_set_up(void);
void bench_tear_down(void);

/* From now on the object is the low `size` bytes of `bits`; 0 bytes: it is refused. */
void give(uint16_t index, uint8_t subindex, uint8_t size, uint64_t bits);

void give_f64(uint16_t index, uint8_t subindex, double number);
played_object_t *last_write(void);

/* The node answers one frame. False: there was none. */
bool serve(void);

/* The poller steps, and the node answers: so many times. */
void exchange(unsigned times);

/* Until nothing more is to be done now. */
void settle(void);

void until_there_is_a_snapshot(void);

/* With the keys. */
void unlock(gateway_session_t *session);

void carry_out(gateway_command_t *command); /* it is taken, and settled */

void pass(uint64_t us);
uint32_t count(int which);

#endif
