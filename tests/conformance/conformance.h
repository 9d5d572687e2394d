/* conformance.h - what every implementation of port.h must do, as checks over two ports on one bus.
 *
 * A bench gives two ports that hear each other and nobody else, a way to let time pass, and what the board promises. A
 * port with non-volatile memory (that of `a` is looked at) loses all that is in it.
 * The suite needs neither libc nor memory beyond its own: it runs on a processor without an operating system as it
 * does in a process.
 *
 *     uint32_t failed = conformance_run(&bench);
 *
 * A check that a board cannot be put through (its controller cannot be taken off the bus, its queue never fills) is
 * reported as skipped, with the reason; never as passed.
 */
#ifndef TUMBLE_TESTS_CONFORMANCE_H
#define TUMBLE_TESTS_CONFORMANCE_H

#include "tumble/port.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum { CONFORMANCE_PASSED = 0, CONFORMANCE_FAILED, CONFORMANCE_SKIPPED } conformance_verdict_t;

typedef struct {
    void *context; /* handed to the functions below */

    const tumble_port_t *a;
    const tumble_port_t *b;

    /* Let so much time pass, of the ports' own clock. */
    void (*pass)(void *context, uint32_t us);

    /* Frames that may wait to be received without a loss. */
    uint32_t burst;

    /* After so many frames sent at once the port must have been BUSY; 0: its queue cannot be filled here. */
    uint32_t send_limit;

    /* What a frame may need from one port to the other when the bus is quiet. */
    uint32_t transit_us;

    /* Take the controller of `a` off the bus, or let it come back; null: cannot be done here. */
    void (*set_off)(void *context, bool off);

    /* What an erase of the non-volatile memory may take. */
    uint32_t erase_us;

    /* As if power had been off: the memory again, with what it held; null: cannot be done here. */
    const tumble_nv_t *(*reopen)(void *context);

    /* A check has ended; `why` is the reason unless it has passed. */
    void (*report)(void *context, const char *check, conformance_verdict_t verdict, const char *why);
} conformance_bench_t;

/* All checks. Returns how many have failed. */
uint32_t conformance_run(const conformance_bench_t *bench);

/* Those of the non-volatile memory alone: of the bench `a`, `pass`, `erase_us`, `reopen` and `report` are in use. */
uint32_t conformance_run_nv(const conformance_bench_t *bench);

#endif
