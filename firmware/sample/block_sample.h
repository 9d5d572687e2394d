/* block_sample.h - one sample of the accelerometer block, wherever it comes from. */
#ifndef TUMBLE_SAMPLE_BLOCK_SAMPLE_H
#define TUMBLE_SAMPLE_BLOCK_SAMPLE_H

#include "tumble/core.h"

#include <stdint.h>

/* Status bits of a raw sample; 0: healthy. */
enum {
    TUMBLE_SAMPLE_SATURATED = 1,  /* a channel is at the end of its range */
    TUMBLE_SAMPLE_SELF_TEST = 2,  /* the block's self-test failed */
    TUMBLE_SAMPLE_CONVERTER = 4,  /* its converter is faulty */
    TUMBLE_SAMPLE_TEMPERATURE = 8 /* it is too cold or too hot */
};

/* The block's timestamp counts milliseconds and wraps here. */
#define TUMBLE_TIMESTAMP_PERIOD_MS 4096U

/* One sample of the block, as it leaves the sample source (CAN frames or a board's own converter). */
typedef struct {
    tumble_sample_t raw;       /* counts, 16-bit sample counter, and TUMBLE_SAMPLE_... as its status */
    uint16_t timestamp_ms;     /* the block's own clock, below TUMBLE_TIMESTAMP_PERIOD_MS (higher bits are ignored) */
    int8_t temperature_half_c; /* block temperature in half degrees Celsius */
} tumble_block_sample_t;

#endif
