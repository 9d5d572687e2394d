#include "simulation/bus.h"

#include <string.h>

void sim_bus_init(sim_bus_t *bus, sim_clock_t *clock, const sim_wire_t *wire, uint32_t bits_per_second)
{
    assert(bits_per_second != 0U && 1000000U % bits_per_second == 0U);
    memset(bus, 0, sizeof *bus);
    bus->clock = clock;
    bus->wire = wire;
    bus->bit_us = 1000000U / bits_per_second;
}

void sim_bus_attach(sim_bus_t *bus, uint8_t node, sim_actor_t actor)
{
    assert(node < SIM_BUS_NODES && !bus->nodes[node].attached);
    bus->nodes[node].attached = true;
    bus->nodes[node].actor = actor;
    for (uint32_t id = 0; id <= TUMBLE_CAN_MAX_ID; id++) {
        bus->listeners[id] = (uint8_t)(bus->listeners[id] | 1U << node);
    }
}

void sim_bus_attach_sender(sim_bus_t *bus, uint8_t node)
{
    assert(node < SIM_BUS_NODES && !bus->nodes[node].attached);
    bus->nodes[node].attached = true;
}

void sim_bus_set_deaf(sim_bus_t *bus, uint8_t node, uint16_t from, uint16_t to)
{
    for (uint32_t id = from; id <= to; id++) {
        bus->listeners[id] = (uint8_t)(bus->listeners[id] & ~(1U << node));
    }
}

void sim_bus_set_loop(sim_bus_t *bus, uint8_t node, uint32_t loop_us)
{
    bus->nodes[node].loop_us = loop_us;
}

void sim_bus_set_down(sim_bus_t *bus, uint8_t node, bool down)
{
    bus->nodes[node].down = down;
    if (down) {
        bus->nodes[node].tx_count = 0;
        bus->nodes[node].rx_count = 0;
        bus->waiting &= ~(1U << node);
    }
}

/* Into the transmit queue; whoever is there when the bus falls idle competes. */
static tumble_status_t enqueue(sim_bus_t *bus, uint8_t node, const tumble_can_frame_t *frame)
{
    sim_bus_node_t *const from = &bus->nodes[node];
    if (from->tx_count == SIM_BUS_TX_DEPTH) {
        from->counters.tx_overflow++;
        return TUMBLE_E_PORT_BUSY;
    }
    from->tx[(from->tx_first + from->tx_count) & (SIM_BUS_TX_DEPTH - 1U)] = *frame;
    from->tx_count++;
    bus->waiting |= 1U << node;
    if (!bus->transmitting) {
        sim_clock_set(bus->clock, SIM_ACTOR_BUS, bus->free_from_us);
    }
    return TUMBLE_OK;
}

static void hold(sim_bus_t *bus, uint8_t node, const tumble_can_frame_t *frame, uint8_t fault, uint64_t due_us)
{
    if (bus->held_count == SIM_BUS_HELD) {
        bus->held_overflow++;
        return;
    }
    bus->held[bus->held_count++] = (sim_bus_held_t){*frame, due_us, node, fault};
    if (due_us != SIM_NEVER) {
        sim_clock_set_no_later(bus->clock, SIM_ACTOR_DELAY, due_us);
    }
}

/* Hand in every held frame that `is_due`; the others keep their order. */
static void release(sim_bus_t *bus, bool (*is_due)(const sim_bus_held_t *held, uint64_t key), uint64_t key)
{
    uint32_t kept = 0;
    const uint32_t count = bus->held_count;
    for (uint32_t i = 0; i < count; i++) {
        const sim_bus_held_t held = bus->held[i];
        if (is_due(&held, key)) {
            (void)enqueue(bus, held.node, &held.frame);
        } else {
            bus->held[kept++] = held;
        }
    }
    bus->held_count = kept;
}

static bool is_due_at(const sim_bus_held_t *held, uint64_t now_us)
{
    return held->due_us <= now_us;
}

static bool is_held_by(const sim_bus_held_t *held, uint64_t fault)
{
    return held->due_us == SIM_NEVER && held->fault == fault;
}

void sim_bus_on_delay(sim_bus_t *bus)
{
    release(bus, is_due_at, bus->clock->now_us);
    for (uint32_t i = 0; i < bus->held_count; i++) {
        if (bus->held[i].due_us != SIM_NEVER) {
            sim_clock_set_no_later(bus->clock, SIM_ACTOR_DELAY, bus->held[i].due_us);
        }
    }
}

static bool picks(sim_bus_fault_t *fault, const tumble_can_frame_t *frame)
{
    if (fault->count == 0U || (frame->id & fault->mask) != fault->match) {
        return false;
    }
    if (fault->probability < 1.0 && sim_random_unit(&fault->random) >= fault->probability) {
        return false;
    }
    if (fault->skip > 0U) {
        fault->skip--;
        return false;
    }
    if (fault->count != UINT32_MAX) {
        fault->count--;
    }
    return true;
}

static void flip_a_bit(sim_bus_fault_t *fault, tumble_can_frame_t *frame)
{
    if (frame->length > 0U) {
        const uint32_t bit = (uint32_t)((sim_random_u64(&fault->random) >> 32) * (8ULL * frame->length) >> 32);
        frame->data[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
    }
}

/* What a fault does to the frame it picked. */
static tumble_status_t strike(sim_bus_t *bus, uint8_t number, uint8_t node, tumble_can_frame_t *frame)
{
    sim_bus_fault_t *const fault = &bus->faults[number];
    switch (fault->kind) {
    case SIM_FRAME_DROP:
        return TUMBLE_OK;
    case SIM_FRAME_CORRUPT:
        flip_a_bit(fault, frame);
        break;
    case SIM_FRAME_TRUNCATE:
        frame->length = (uint8_t)((frame->length > 0U) ? frame->length - 1U : 0U);
        break;
    case SIM_FRAME_DELAY:
        hold(bus, node, frame, number, bus->clock->now_us + fault->delay_us);
        return TUMBLE_OK;
    case SIM_FRAME_REORDER:
        fault->holding = true;
        hold(bus, node, frame, number, SIM_NEVER);
        return TUMBLE_OK;
    case SIM_FRAME_DUPLICATE:
        (void)enqueue(bus, node, frame);
        break;
    }
    return enqueue(bus, node, frame);
}

static tumble_status_t send_through_faults(sim_bus_t *bus, uint8_t node, const tumble_can_frame_t *frame)
{
    for (uint32_t i = 0; i < SIM_BUS_FAULTS; i++) {
        sim_bus_fault_t *const fault = &bus->faults[i];
        if ((bus->faulty >> i & 1U) == 0U) {
            continue;
        }
        if (fault->holding && (frame->id & fault->mask) == fault->match) {
            const tumble_status_t status = enqueue(bus, node, frame);
            fault->holding = false;
            release(bus, is_held_by, i);
            return status;
        }
        if (picks(fault, frame)) {
            tumble_can_frame_t copy = *frame;
            return strike(bus, (uint8_t)i, node, &copy);
        }
    }
    return enqueue(bus, node, frame);
}

tumble_status_t sim_bus_send(sim_bus_t *bus, uint8_t node, const tumble_can_frame_t *frame)
{
    if (node >= SIM_BUS_NODES || !bus->nodes[node].attached || frame->id > TUMBLE_CAN_MAX_ID ||
        frame->length > TUMBLE_CAN_MAX_BYTES) {
        return TUMBLE_E_ARGUMENT;
    }
    if (bus->nodes[node].down) {
        return TUMBLE_E_PORT_DOWN;
    }
    if (bus->faulty != 0U) {
        return send_through_faults(bus, node, frame);
    }
    return enqueue(bus, node, frame);
}

tumble_status_t sim_bus_receive(sim_bus_t *bus, uint8_t node, tumble_can_frame_t *frame)
{
    if (node >= SIM_BUS_NODES) {
        return TUMBLE_E_ARGUMENT;
    }
    sim_bus_node_t *const at = &bus->nodes[node];
    if (at->down) {
        return TUMBLE_E_PORT_DOWN;
    }
    if (at->rx_count == 0U) {
        return TUMBLE_E_PORT_EMPTY;
    }
    *frame = at->rx[at->rx_first];
    at->rx_first = (at->rx_first + 1U) & (SIM_BUS_RX_DEPTH - 1U);
    at->rx_count--;
    return TUMBLE_OK;
}

static uint64_t end_now_us(void *context)
{
    return ((const sim_bus_end_t *)context)->bus->clock->now_us;
}

static tumble_status_t end_send(void *context, const tumble_can_frame_t *frame)
{
    const sim_bus_end_t *const end = context;
    return sim_bus_send(end->bus, end->node, frame);
}

static tumble_status_t end_receive(void *context, tumble_can_frame_t *frame)
{
    const sim_bus_end_t *const end = context;
    return sim_bus_receive(end->bus, end->node, frame);
}

tumble_port_t sim_bus_port(sim_bus_end_t *end)
{
    return (tumble_port_t){.context = end, .now_us = end_now_us, .can_send = end_send, .can_receive = end_receive};
}

/* Of all nodes with something to send the one with the lowest identifier; of equals, the lowest node. */
static uint8_t arbitrate(const sim_bus_t *bus)
{
    uint8_t winner = 0;
    uint32_t lowest = TUMBLE_CAN_MAX_ID + 1U;
    for (uint32_t left = bus->waiting; left != 0U; left &= left - 1U) {
        const uint8_t n = (uint8_t)__builtin_ctz(left);
        const sim_bus_node_t *const node = &bus->nodes[n];
        if (node->tx[node->tx_first].id < lowest) {
            lowest = node->tx[node->tx_first].id;
            winner = n;
        }
    }
    return winner;
}

static void begin_frame(sim_bus_t *bus, uint64_t start_us)
{
    bus->sender = arbitrate(bus);
    sim_bus_node_t *const node = &bus->nodes[bus->sender];
    const tumble_can_frame_t *const frame = &node->tx[node->tx_first];
    const uint32_t bits = sim_frame_bits(bus->wire, frame); /* of the original: to read a fresh copy takes longer */
    bus->flying = *frame;
    node->tx_first = (node->tx_first + 1U) & (SIM_BUS_TX_DEPTH - 1U);
    node->tx_count--;
    if (node->tx_count == 0U) {
        bus->waiting &= ~(1U << bus->sender);
    }
    const uint64_t end_us = start_us + (uint64_t)(bits - SIM_INTERFRAME_BITS) * bus->bit_us;
    bus->free_from_us = end_us + (uint64_t)SIM_INTERFRAME_BITS * bus->bit_us;
    bus->load.frames++;
    bus->load.bits += bits;
    bus->load.busy_us += (uint64_t)bits * bus->bit_us;
    bus->transmitting = true;
    sim_clock_set(bus->clock, SIM_ACTOR_BUS, end_us);
}

static void wake(const sim_bus_t *bus, const sim_bus_node_t *node)
{
    uint64_t at_us = bus->clock->now_us;
    if (node->loop_us != 0U) {
        const uint64_t late_us = at_us % node->loop_us;
        at_us += (late_us != 0U) ? node->loop_us - late_us : 0U;
    }
    sim_clock_set_no_later(bus->clock, node->actor, at_us);
}

static void deliver_to(sim_bus_t *bus, sim_bus_node_t *node)
{
    if (node->down) {
        return;
    }
    if (node->rx_count == SIM_BUS_RX_DEPTH) {
        node->counters.rx_overflow++;
        return;
    }
    node->rx[(node->rx_first + node->rx_count) & (SIM_BUS_RX_DEPTH - 1U)] = bus->flying;
    node->rx_count++;
    node->counters.received++;
    wake(bus, node);
}

static void end_frame(sim_bus_t *bus)
{
    bus->transmitting = false;
    bus->nodes[bus->sender].counters.sent++;
    if (bus->tap != NULL) {
        bus->tap(bus->tap_context, bus->clock->now_us, bus->sender, &bus->flying);
    }
    const uint32_t others = bus->listeners[bus->flying.id] & ~(1U << bus->sender);
    for (uint32_t left = others; left != 0U; left &= left - 1U) {
        deliver_to(bus, &bus->nodes[__builtin_ctz(left)]);
    }
    if (bus->waiting == 0U) {
        return;
    }
    if (sim_clock_next_us(bus->clock) > bus->free_from_us) {
        begin_frame(bus, bus->free_from_us); /* nobody can join the arbitration any more */
    } else {
        sim_clock_set(bus->clock, SIM_ACTOR_BUS, bus->free_from_us);
    }
}

void sim_bus_on_alarm(sim_bus_t *bus)
{
    if (bus->transmitting) {
        end_frame(bus);
    } else if (bus->waiting != 0U) {
        begin_frame(bus, bus->clock->now_us);
    }
}

void sim_bus_begin_fault(sim_bus_t *bus, uint32_t number, const sim_bus_fault_t *fault)
{
    assert(number < SIM_BUS_FAULTS);
    bus->faults[number] = *fault;
    bus->faulty |= 1U << number;
}

void sim_bus_end_fault(sim_bus_t *bus, uint32_t number)
{
    assert(number < SIM_BUS_FAULTS);
    bus->faults[number].holding = false;
    bus->faulty &= ~(1U << number);
    release(bus, is_held_by, number);
}
