/* embed_board.c - the board of examples/embed.c, played: a block of known coefficients on an ideal stand, and a memory
 * like flash. On a real board these are the drivers of converter and flash. */
#include "embed_board.h"

#include <string.h>

#define V_PER_COUNT 1e-6
#define SECTOR 4096U
#define GRANULE 8U

static const double K[3][3] = {{2.0, 0.03, -0.02}, {-0.02, -1.9, 0.03}, {0.02, -0.03, 2.1}};
static const double U0[3] = {0.1, -0.2, 0.3};
static uint8_t flash[8U * SECTOR];

/* The next sample, with noise: evenly spread over 512 counts, a standard deviation of 148. */
const tumble_sample_t *board_sample(uint8_t position)
{
    static tumble_sample_t sample;
    static uint32_t dice;
    double a_g[3];
    tumble_schedule_attitude(&tumble_schedule_paper, position, a_g);
    sample.counter++;
    for (int i = 0; i < 3; i++) {
        dice = (dice * 1664525U) + 1013904223U;
        const double u_v = U0[i] + (K[i][0] * a_g[0]) + (K[i][1] * a_g[1]) + (K[i][2] * a_g[2]);
        sample.counts[i] = (int32_t)(u_v / V_PER_COUNT) + (int32_t)(dice >> 23) - 256;
    }
    return &sample;
}

static tumble_status_t erase(void *context, uint32_t offset)
{
    (void)context;
    if (((offset % SECTOR) != 0U) || (offset >= sizeof flash)) {
        return TUMBLE_E_NV;
    }
    memset(&flash[offset], 0xFF, SECTOR);
    return TUMBLE_OK;
}

static tumble_status_t program(void *context, uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    (void)context;
    if ((size == 0U) || (((offset | size) % GRANULE) != 0U) || (offset >= sizeof flash) ||
        (size > (SECTOR - (offset % SECTOR)))) {
        return TUMBLE_E_NV;
    }
    for (uint32_t i = 0; i < size; i++) {
        if (flash[offset + i] != 0xFFU) { /* a granule is programmed once after each erase */
            return TUMBLE_E_NV;
        }
    }
    memcpy(&flash[offset], bytes, size);
    return TUMBLE_OK;
}

static tumble_status_t read(void *context, uint32_t offset, uint8_t *bytes, uint32_t size)
{
    (void)context;
    if ((offset > sizeof flash) || (size > (sizeof flash - offset))) {
        return TUMBLE_E_NV;
    }
    memcpy(bytes, &flash[offset], size);
    return TUMBLE_OK;
}

const tumble_nv_t board_memory = {
    .size_bytes = sizeof flash,
    .sector_bytes = SECTOR,
    .granule_bytes = GRANULE,
    .erase = erase,
    .program = program,
    .read = read,
};
