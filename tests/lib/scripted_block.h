/* scripted_block.h - the accelerometer block as a script: NMT state, heartbeat, exact samples of a given K and U0.
 *
 * Frame level only, no noise of its own but a small periodic pattern, so that no channel looks stuck.
 */
#ifndef TUMBLE_TESTS_SCRIPTED_BLOCK_H
#define TUMBLE_TESTS_SCRIPTED_BLOCK_H

#include "canopen/nmt.h"
#include "fake_port.h"
#include "simulation/block_encode.h"
#include "tumble/core.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#define SCRIPTED_BLOCK_NODE 3U
#define SCRIPTED_PI 3.14159265358979323846

typedef struct {
    double k_v_per_g[3][3];
    double u0_v[3];
    double v_per_count;
    const tumble_mounting_t *mounting; /* how it sits on the table */
    uint64_t next_heartbeat_us;
    uint64_t next_sample_us;
    uint32_t period_us;
    uint32_t sent; /* samples */
    uint16_t counter;
    uint8_t nmt;
    uint8_t status;
    int8_t temperature_half_c;
    bool dead;
} scripted_block_t;

void scripted_block_boot(scripted_block_t *block, fake_port_t *fake);
void scripted_block_init(scripted_block_t *block, fake_port_t *fake, const tumble_mounting_t *mounting);
void scripted_block_hear(scripted_block_t *block, fake_port_t *fake, const tumble_can_frame_t *frame);

/* The outputs at a table angle, on the ideal stand. */
void scripted_block_outputs(const scripted_block_t *block, double angle_deg, double u_v[3]);

void scripted_block_step(scripted_block_t *block, fake_port_t *fake, double angle_deg);
uint64_t scripted_block_next_us(const scripted_block_t *block);

#endif
