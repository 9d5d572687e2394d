#include "scripted_block.h"

void scripted_block_boot(scripted_block_t *block, fake_port_t *fake)
{
    const tumble_can_frame_t boot_up = {.id = TUMBLE_HEARTBEAT_ID + SCRIPTED_BLOCK_NODE, .length = 1};
    block->nmt = TUMBLE_NMT_PRE_OPERATIONAL;
    block->counter = 0;
    block->next_heartbeat_us = fake->now_us + 100000U;
    block->next_sample_us = UINT64_MAX;
    fake_port_give(fake, &boot_up);
}

void scripted_block_init(scripted_block_t *block, fake_port_t *fake, const tumble_mounting_t *mounting)
{
    *block = (scripted_block_t){
        .k_v_per_g = {{-2.0, 0.03, -0.02}, {0.01, -2.1, 0.04}, {-0.03, 0.02, -1.9}},
        .u0_v = {0.01, -0.02, 0.005},
        .v_per_count = 1e-6,
        .mounting = mounting,
        .period_us = 10000,
        .temperature_half_c = 50,
    };
    scripted_block_boot(block, fake);
}

void scripted_block_hear(scripted_block_t *block, fake_port_t *fake, const tumble_can_frame_t *frame)
{
    const bool mine = (frame->id == TUMBLE_NMT_ID) && (frame->length == 2U) &&
                      ((frame->data[1] == 0U) || (frame->data[1] == SCRIPTED_BLOCK_NODE));
    if (mine && !block->dead && (frame->data[0] == TUMBLE_NMT_START) && (block->nmt != TUMBLE_NMT_OPERATIONAL)) {
        block->nmt = TUMBLE_NMT_OPERATIONAL;
        block->next_sample_us = fake->now_us + block->period_us;
    }
}

void scripted_block_outputs(const scripted_block_t *block, double angle_deg, double u_v[3])
{
    const double phi = angle_deg * SCRIPTED_PI / 180.0;
    const double f[3] = {sin(phi), 0.0, cos(phi)};
    for (int i = 0; i < 3; i++) {
        u_v[i] = block->u0_v[i];
        for (int j = 0; j < 3; j++) {
            const double *row = block->mounting->matrix[j];
            u_v[i] += block->k_v_per_g[i][j] * (row[0] * f[0] + row[1] * f[1] + row[2] * f[2]);
        }
    }
}

static void scripted_block_send_sample(scripted_block_t *block, fake_port_t *fake, double angle_deg)
{
    double u_v[3];
    tumble_block_sample_t sample = {
        .raw = {.counter = block->counter, .status = block->status},
        .timestamp_ms = (uint16_t)((fake->now_us / 1000U) % TUMBLE_TIMESTAMP_PERIOD_MS),
        .temperature_half_c = block->temperature_half_c,
    };
    scripted_block_outputs(block, angle_deg, u_v);
    for (int i = 0; i < 3; i++) {
        const int32_t pattern = ((int32_t)(block->sent % 3U) - 1) * (i + 1); /* sums to 0 over three samples */
        sample.raw.counts[i] = (int32_t)lround(u_v[i] / block->v_per_count) + pattern;
    }
    sim_block_frames_t frames;
    sim_block_encode(&sample, &frames);
    fake_port_give(fake, &frames.xy);
    fake_port_give(fake, &frames.z);
    block->counter++;
    block->sent++;
}

void scripted_block_step(scripted_block_t *block, fake_port_t *fake, double angle_deg)
{
    if (block->dead) {
        return;
    }
    if (fake->now_us >= block->next_heartbeat_us) {
        const tumble_can_frame_t beat = {
            .id = TUMBLE_HEARTBEAT_ID + SCRIPTED_BLOCK_NODE, .length = 1, .data = {block->nmt}};
        fake_port_give(fake, &beat);
        block->next_heartbeat_us = fake->now_us + 100000U;
    }
    if ((block->nmt == TUMBLE_NMT_OPERATIONAL) && (fake->now_us >= block->next_sample_us)) {
        scripted_block_send_sample(block, fake, angle_deg);
        block->next_sample_us = fake->now_us + block->period_us;
    }
}

uint64_t scripted_block_next_us(const scripted_block_t *block)
{
    if (block->dead) {
        return UINT64_MAX;
    }
    const bool streams = (block->nmt == TUMBLE_NMT_OPERATIONAL) && (block->next_sample_us < block->next_heartbeat_us);
    return streams ? block->next_sample_us : block->next_heartbeat_us;
}
