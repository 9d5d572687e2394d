#include "stand_bridge.h"

#include "core/bytes.h"
#include "port_linux.h"

#define TURN_COMMAND CAN_EFF_FLAG /* with identifier 0 */
#define DEG_PER_UNIT 1e-5

static void queue_put(frame_queue_t *queue, const tumble_can_frame_t *frame)
{
    if (queue->count == FRAME_QUEUE_DEPTH) {
        queue->overflow++;
        return;
    }
    queue->frames[(queue->first + queue->count++) % FRAME_QUEUE_DEPTH] = *frame;
}

/* The oldest, or null. */
static const tumble_can_frame_t *queue_peek(const frame_queue_t *queue)
{
    return (queue->count > 0U) ? &queue->frames[queue->first] : NULL;
}

/* Take the oldest away; there is one. */
static void queue_pop(frame_queue_t *queue)
{
    queue->first = (queue->first + 1U) % FRAME_QUEUE_DEPTH;
    queue->count--;
}

static void turn_table(bench_world_t *world, const uint8_t *data)
{
    const double angle_deg = DEG_PER_UNIT * (double)tumble_get_i32(data);
    const double speed_deg_s = DEG_PER_UNIT * (double)tumble_get_u32(data + 4);
    if (speed_deg_s > 0.0) {
        bench_world_turn(world, angle_deg, speed_deg_s);
    }
}

bool stand_bridge_next(stand_bridge_t *bridge, struct can_frame *raw, uint64_t *utc_us)
{
    if (can_socket_receive(&bridge->can, raw) != CAN_SOCKET_OK) {
        return false;
    }
    *utc_us = can_socket_stamp_us(&bridge->can);
    return true;
}

void stand_bridge_take(stand_bridge_t *bridge, bench_world_t *world, const struct can_frame *raw)
{
    tumble_can_frame_t frame;
    if (port_linux_from(raw, &frame)) {
        queue_put(&bridge->in, &frame);
        stand_bridge_feed(bridge, world);
    } else if (raw->can_id == TURN_COMMAND && raw->can_dlc == TUMBLE_CAN_MAX_BYTES && !world->config->present.drive) {
        turn_table(world, raw->data);
    } else {
        bridge->foreign++;
    }
}

void stand_bridge_feed(stand_bridge_t *bridge, bench_world_t *world)
{
    const tumble_can_frame_t *frame;
    while ((frame = queue_peek(&bridge->in)) != NULL &&
           world->bus.nodes[STAND_BUS_INTERFACE].tx_count < SIM_BUS_TX_DEPTH) {
        (void)sim_bus_send(&world->bus, STAND_BUS_INTERFACE, frame);
        queue_pop(&bridge->in);
    }
}

/* False: it must wait. */
static bool send(stand_bridge_t *bridge, const tumble_can_frame_t *frame)
{
    struct can_frame raw;
    port_linux_to(frame, &raw);
    const can_socket_status_t status = can_socket_send(&bridge->can, &raw);
    if (status == CAN_SOCKET_DOWN) {
        bridge->unsent++;
    }
    return status != CAN_SOCKET_BUSY;
}

void stand_bridge_tell(stand_bridge_t *bridge, uint8_t sender, const tumble_can_frame_t *frame)
{
    if (sender != STAND_BUS_INTERFACE && (bridge->out.count > 0U || !send(bridge, frame))) {
        queue_put(&bridge->out, frame);
    }
}

bool stand_bridge_flush(stand_bridge_t *bridge)
{
    const tumble_can_frame_t *frame;
    while ((frame = queue_peek(&bridge->out)) != NULL && send(bridge, frame)) {
        queue_pop(&bridge->out);
    }
    return bridge->out.count > 0U;
}
