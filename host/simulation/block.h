/* block.h - the accelerometer block: a CANopen node that streams its raw outputs while it is Operational.
 */
#ifndef TUMBLE_SIMULATION_BLOCK_H
#define TUMBLE_SIMULATION_BLOCK_H

#include "canopen/node.h"
#include "simulation/axis.h"
#include "simulation/block_encode.h"
#include "simulation/block_objects.h"
#include "simulation/bus.h"
#include "simulation/clock.h"
#include "simulation/geometry.h"
#include "simulation/scenario.h"
#include "simulation/sensor.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    const sim_block_config_t *config;
    sim_clock_t *clock;
    sim_bus_end_t bus;
    const sim_axis_t *axis;
    tumble_port_t port;
    tumble_node_t node;
    tumble_block_objects_t objects;
    sim_sensor_t sensor;
    sim_geometry_t geometry; /* of how it sits on the table now */
    uint64_t powered_us;     /* when it was switched on */
    uint64_t node_us;        /* when the node wants to be looked at */
    uint64_t sample_us;      /* next sample; SIM_NEVER: not streaming */
    uint32_t period_us;
    uint32_t counter; /* samples made since it became Operational */
    bool powered;
    bool still; /* `force_g` holds as long as the axis does not move */
    double force_g[TUMBLE_CHANNELS];
    sim_fault_effects_t faults; /* in force */
    sim_block_frames_t kept;    /* a sample that is to come behind the next */
    bool keeps;
} sim_block_t;

/* Power on. `sensor` holds the true K and U0 and must outlive the block, like the rest that is handed in. Say how it
 * sits (sim_block_mount) before time passes. */
void sim_block_init(sim_block_t *block, const sim_block_config_t *config, const sim_sensor_config_t *sensor,
                    uint64_t seed, sim_clock_t *clock, sim_bus_t *bus, uint8_t bus_node, const sim_axis_t *axis);

/* The block sits on the table in another way. */
void sim_block_mount(sim_block_t *block, const sim_geometry_t *geometry);

/* The axis may have moved in a way that only its owner knows of (slip, a jam that comes free): look again. */
void sim_block_disturb(sim_block_t *block);

/* Frames have come, a sample is due, or the node's own time. */
void sim_block_on_alarm(sim_block_t *block);

void sim_block_set_power(sim_block_t *block, bool on);

#endif
