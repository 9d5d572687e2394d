#include "simulation/block.h"

#include <math.h> /* floor: exact */
#include <stddef.h>
#include <string.h>

#define LEAST_HALF_DEGREES (-128.0)
#define MOST_HALF_DEGREES 127.0

/* Streams while Operational, from its first sample on. */
static void state_changed(void *context, tumble_nmt_state_t state)
{
    sim_block_t *const block = context;
    block->sample_us =
        (state == TUMBLE_NMT_OPERATIONAL) ? block->clock->now_us + block->config->first_sample_us : SIM_NEVER;
}

static tumble_abort_t check_write(void *context, const tumble_entry_t *entry, const uint8_t *bytes, uint8_t size)
{
    sim_block_t *const block = context;
    (void)size;
    if ((entry->home == TUMBLE_HOME_VARIABLES) && (entry->offset == offsetof(tumble_block_objects_t, sample_rate))) {
        block->period_us = 1000000U / ((uint32_t)bytes[0] | (uint32_t)bytes[1] << 8); /* the table refuses 0 */
    }
    return TUMBLE_ABORT_NONE;
}

static void wake_up(sim_block_t *block)
{
    block->objects = tumble_block_objects_initial;
    block->objects.sample_rate = (uint16_t)(1000000U / block->config->sample_period_us);
    block->objects.converter_bits = block->sensor.config->converter_bits;
    block->objects.converter_range = block->sensor.config->range_v;
    block->period_us = block->config->sample_period_us;
    block->counter = block->config->first_counter;
    block->sample_us = SIM_NEVER;
    block->keeps = false;
}

static void reset(void *context, bool application)
{
    sim_block_t *const block = context;
    block->sample_us = SIM_NEVER;
    if (application) {
        wake_up(block);
    }
}

static const tumble_object_hooks_t HOOKS = {.write = check_write};
static const tumble_node_events_t EVENTS = {.state_changed = state_changed, .reset = reset};

static const tumble_node_config_t NODE = {.table = &tumble_block_table,
                                          .defaults = &tumble_block_defaults,
                                          .hooks = &HOOKS,
                                          .events = &EVENTS,
                                          .node = TUMBLE_BLOCK_NODE};

static void boot(sim_block_t *block)
{
    const tumble_node_binding_t binding = {.port = &block->port, .variables = &block->objects, .context = block};
    wake_up(block);
    const tumble_status_t status = tumble_node_init(&block->node, &NODE, &binding);
    assert(status == TUMBLE_OK);
    (void)status;
    block->powered = true;
    block->powered_us = block->clock->now_us;
    block->node_us = block->clock->now_us;
    sim_clock_set(block->clock, SIM_ACTOR_BLOCK, block->clock->now_us);
}

void sim_block_init(sim_block_t *block, const sim_block_config_t *config, const sim_sensor_config_t *sensor,
                    uint64_t seed, sim_clock_t *clock, sim_bus_t *bus, uint8_t bus_node, const sim_axis_t *axis)
{
    memset(block, 0, sizeof *block);
    block->config = config;
    block->clock = clock;
    block->bus = (sim_bus_end_t){bus, bus_node};
    block->axis = axis;
    block->port = sim_bus_port(&block->bus);
    sim_sensor_init(&block->sensor, sensor, seed);
    sim_bus_attach(bus, bus_node, SIM_ACTOR_BLOCK);
    boot(block);
}

void sim_block_mount(sim_block_t *block, const sim_geometry_t *geometry)
{
    block->geometry = *geometry;
    block->still = false;
}

void sim_block_disturb(sim_block_t *block)
{
    block->still = false;
}

void sim_block_set_power(sim_block_t *block, bool on)
{
    if (on == block->powered) {
        return;
    }
    sim_bus_set_down(block->bus.bus, block->bus.node, !on);
    if (on) {
        boot(block);
        return;
    }
    block->powered = false;
    sim_clock_set(block->clock, SIM_ACTOR_BLOCK, SIM_NEVER);
}

/* The force changes only while the axis does. */
static const double *feel(sim_block_t *block)
{
    const uint64_t now = block->clock->now_us;
    const bool still = sim_axis_is_still(block->axis, now);
    if (!still || !block->still) {
        sim_geometry_force(&block->geometry, sim_axis_actual_deg(block->axis, now), block->force_g);
    }
    block->still = still;
    return block->force_g;
}

static int8_t half_degrees(double temperature_c)
{
    const double halves = floor(2.0 * temperature_c + 0.5);
    if (halves < LEAST_HALF_DEGREES) {
        return (int8_t)LEAST_HALF_DEGREES;
    }
    return (int8_t)((halves > MOST_HALF_DEGREES) ? MOST_HALF_DEGREES : halves);
}

static bool use_up(sim_block_t *block, sim_fault_kind_t kind)
{
    uint32_t *const count = &block->faults[kind].count;
    if (*count == 0U) {
        return false;
    }
    *count -= (*count != UINT32_MAX) ? 1U : 0U;
    return true;
}

static void send_sample(sim_block_t *block, const sim_block_frames_t *frames)
{
    (void)sim_bus_send(block->bus.bus, block->bus.node, &frames->xy); /* no room: counted by the bus, and lost */
    (void)sim_bus_send(block->bus.bus, block->bus.node, &frames->z);
    block->objects.samples_sent++;
}

/* Through whatever is wrong with the sending. */
static void dispatch(sim_block_t *block, sim_block_frames_t *frames)
{
    if (block->faults[SIM_FAULT_NO_SAMPLES].on || use_up(block, SIM_FAULT_LOST_SAMPLES)) {
        return;
    }
    if (use_up(block, SIM_FAULT_WRONG_CRC)) {
        frames->z.data[7] ^= 0x5AU;
    }
    if (!block->keeps && use_up(block, SIM_FAULT_REORDERED_SAMPLES)) {
        block->kept = *frames;
        block->keeps = true;
        return;
    }
    send_sample(block, frames);
    if (block->keeps) {
        block->keeps = false;
        send_sample(block, &block->kept);
    }
    if (use_up(block, SIM_FAULT_REPEATED_SAMPLES)) {
        send_sample(block, frames);
    }
}

static void make_sample(sim_block_t *block)
{
    const uint64_t age_us = block->clock->now_us - block->powered_us;
    const double age_s = (double)block->clock->now_us * 1e-6;
    sim_block_frames_t frames;
    tumble_block_sample_t sample;
    const bool saturated = sim_sensor_sample(&block->sensor, feel(block), age_s, sample.raw.counts);
    block->objects.status = (uint8_t)((uint8_t)block->faults[SIM_FAULT_STATUS].value | (saturated ? 1U : 0U));
    block->objects.temperature = half_degrees(sim_sensor_temperature_c(&block->sensor, age_s));
    sample.raw.counter = (uint16_t)block->counter++;
    sample.timestamp_ms = (uint16_t)(block->config->first_timestamp_ms + age_us / 1000U);
    sample.raw.status = block->objects.status;
    sample.temperature_half_c = block->objects.temperature;
    sim_block_encode(&sample, &frames);
    dispatch(block, &frames);
}

static uint64_t earlier(uint64_t a_us, uint64_t b_us)
{
    return (a_us < b_us) ? a_us : b_us;
}

void sim_block_on_alarm(sim_block_t *block)
{
    const uint64_t now = block->clock->now_us;
    tumble_can_frame_t frame;
    if (!block->powered) {
        return;
    }
    bool heard = false;
    while (tumble_link_receive(&block->node.link, &frame) == TUMBLE_OK) {
        (void)tumble_node_receive(&block->node, &frame, now);
        heard = true;
    }
    if (now >= block->sample_us) {
        block->sample_us += block->period_us;
        make_sample(block);
    }
    if (heard || now >= block->node_us) {
        tumble_node_step(&block->node, now);
        block->node_us = sim_clock_again_us(block->clock, tumble_node_next_us(&block->node));
    }
    sim_clock_set(block->clock, SIM_ACTOR_BLOCK, earlier(block->sample_us, block->node_us));
}
