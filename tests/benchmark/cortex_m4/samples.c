/* samples.c - the sample path: SAMPLES samples at a time, as a converter of 24 bits with some noise gives them, and the
 * division that makes means of a run.
 */
#include "benchmark.h"
#include "tumble/core.h"

#define KINDS 64U
#define POSITIONS 18

static tumble_averaging_t averaging;
static tumble_blocks_t blocks;
static tumble_noise_t noise;
static tumble_averaging_config_t config = {.saturation_counts = 0x7FFFFF,
                                           .min_samples = 50,
                                           .max_lost = 3,
                                           .stuck_run = 50,
                                           .noise_counts = 20.0F,
                                           .stillness_ratio = 2.0F};
static tumble_sample_t samples[KINDS];
static tumble_means_t means;

/* Noise of some counts about a value of its own for each channel, from the generator of Numerical Recipes. */
static void make_samples(void)
{
    uint32_t state = 1;
    for (uint32_t s = 0; s < KINDS; s++) {
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            state = state * 1664525U + 1013904223U;
            samples[s].counts[i] = (i - 1) * 3000000 + (int32_t)(state >> 26) - 32;
        }
    }
}

void samples_begin(void)
{
    make_samples();
    (void)tumble_averaging_init(&averaging, &config);
    (void)tumble_blocks_init(&blocks, 50U);
    for (uint8_t p = 0; p < POSITIONS; p++) {
        (void)tumble_averaging_begin(&averaging, p);
        tumble_blocks_begin(&blocks);
        for (uint32_t s = 0; s < 50U; s++) {
            tumble_averaging_accumulate(&averaging, samples[(s + p) % KINDS].counts);
            tumble_blocks_add(&blocks, samples[(s + p) % KINDS].counts);
        }
        tumble_blocks_finish(&blocks);
        (void)tumble_averaging_finish(&averaging, &config);
    }
    (void)tumble_averaging_begin(&averaging, POSITIONS);
}

static uint16_t counter;

/* What the loops below cost without the sample path. */
tumble_status_t samples_none(void)
{
    for (uint32_t s = 0; s < SAMPLES; s++) {
        samples[s % KINDS].counter = counter++;
        __asm__ volatile("" : : "r"(&samples[s % KINDS]) : "memory");
    }
    return TUMBLE_OK;
}

tumble_status_t samples_without_gates(void)
{
    for (uint32_t s = 0; s < SAMPLES; s++) {
        samples[s % KINDS].counter = counter++;
        tumble_averaging_accumulate(&averaging, samples[s % KINDS].counts);
    }
    return TUMBLE_OK;
}

tumble_status_t samples_with_gates(void)
{
    tumble_status_t status = TUMBLE_OK;
    for (uint32_t s = 0; (s < SAMPLES) && (status == TUMBLE_OK); s++) {
        samples[s % KINDS].counter = counter++;
        status = tumble_averaging_add(&averaging, &config, &samples[s % KINDS]);
    }
    return status;
}

tumble_status_t samples_divide(void)
{
    return tumble_averaging_means(&averaging, 1e-6, &means);
}

/* Beside one of the two above. */
tumble_status_t samples_in_blocks(void)
{
    for (uint32_t s = 0; s < SAMPLES; s++) {
        samples[s % KINDS].counter = counter++;
        tumble_blocks_add(&blocks, samples[s % KINDS].counts);
    }
    return TUMBLE_OK;
}

/* Above the declared noise, in all channels. */
tumble_status_t samples_noise(void)
{
    static const tumble_stand_record_t stand = {.noise_v = 1e-6, .samples = 50};
    return tumble_blocks_noise(&blocks, &averaging, &stand, 1e-6, &noise);
}
