/* inprocess.h - two nodes of the simulated bus as ports, one of them with a simulated flash memory, in virtual time. */
#ifndef TUMBLE_TESTS_INPROCESS_H
#define TUMBLE_TESTS_INPROCESS_H

#include "conformance.h"
#include "simulation/bus.h"
#include "simulation/clock.h"
#include "simulation/nv.h"

#include <string.h>

typedef struct inprocess inprocess_t;

typedef struct {
    inprocess_t *bench;
    uint8_t node;
} inprocess_node_t;

struct inprocess {
    sim_clock_t clock;
    sim_wire_t wire;
    sim_bus_t bus;
    inprocess_node_t nodes[2];
    tumble_port_t ports[2];
    sim_nv_t nv;
};

static inline uint64_t inprocess_now_us(void *context)
{
    const inprocess_node_t *node = context;
    return node->bench->clock.now_us;
}

static inline tumble_status_t inprocess_send(void *context, const tumble_can_frame_t *frame)
{
    const inprocess_node_t *node = context;
    return sim_bus_send(&node->bench->bus, node->node, frame);
}

static inline tumble_status_t inprocess_receive(void *context, tumble_can_frame_t *frame)
{
    const inprocess_node_t *node = context;
    return sim_bus_receive(&node->bench->bus, node->node, frame);
}

/* Time goes on; the nodes themselves are woken for nothing. */
static inline void inprocess_pass(void *context, uint32_t us)
{
    inprocess_t *bench = context;
    const uint64_t end_us = bench->clock.now_us + us;
    sim_actor_t actor;
    while (sim_clock_next(&bench->clock, end_us, &actor)) {
        if (actor == SIM_ACTOR_BUS) {
            sim_bus_on_alarm(&bench->bus);
        }
    }
    bench->clock.now_us = end_us;
}

static inline void inprocess_set_off(void *context, bool off)
{
    inprocess_t *bench = context;
    sim_bus_set_down(&bench->bus, 0, off);
}

/* A memory of another time, with the same bytes. */
static inline const tumble_nv_t *inprocess_reopen(void *context)
{
    static uint8_t bytes[SIM_NV_BYTES];
    inprocess_t *bench = context;
    const uint32_t erase_us = bench->nv.erase_us;
    memcpy(bytes, bench->nv.bytes, sizeof bytes);
    sim_nv_init(&bench->nv, &bench->clock);
    memcpy(bench->nv.bytes, bytes, sizeof bytes);
    bench->nv.erase_us = erase_us;
    return &bench->nv.nv;
}

static inline void inprocess_init(inprocess_t *inprocess)
{
    sim_clock_init(&inprocess->clock);
    sim_wire_init(&inprocess->wire);
    sim_bus_init(&inprocess->bus, &inprocess->clock, &inprocess->wire, 500000);
    sim_bus_attach(&inprocess->bus, 0, SIM_ACTOR_NAVCOMP);
    sim_bus_attach(&inprocess->bus, 1, SIM_ACTOR_DRIVE);
    for (uint8_t n = 0; n < 2U; n++) {
        inprocess->nodes[n] = (inprocess_node_t){inprocess, n};
        inprocess->ports[n] = (tumble_port_t){.context = &inprocess->nodes[n],
                                              .now_us = inprocess_now_us,
                                              .can_send = inprocess_send,
                                              .can_receive = inprocess_receive};
    }
    sim_nv_init(&inprocess->nv, &inprocess->clock);
    inprocess->nv.erase_us = 50000; /* as NOR flash has it */
    inprocess->nv.program_us = 200;
    inprocess->ports[0].nv = &inprocess->nv.nv;
}

static inline conformance_bench_t inprocess_bench(inprocess_t *inprocess)
{
    return (conformance_bench_t){.context = inprocess,
                                 .a = &inprocess->ports[0],
                                 .b = &inprocess->ports[1],
                                 .pass = inprocess_pass,
                                 .burst = SIM_BUS_RX_DEPTH,
                                 .send_limit = SIM_BUS_TX_DEPTH,
                                 .transit_us = 300, /* 8 bytes with stuff bits: up to 270 us at 500 kbit/s */
                                 .set_off = inprocess_set_off,
                                 .erase_us = 50000,
                                 .reopen = inprocess_reopen};
}

#endif
