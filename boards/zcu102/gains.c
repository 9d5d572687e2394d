#include "gains.h"

#include "tumble/core.h"

#include <stddef.h>
#include <stdint.h>

#ifdef ZCU102_EMULATED
#define GAINS_ADDRESS 0x1A00000U
#define GAINS_BYTES 0x10000U

static tumble_optimal_t work;
static const tumble_optimal_source_t SOURCE = {
    .record = (const void *)(uintptr_t)GAINS_ADDRESS, .record_bytes = GAINS_BYTES, .work = &work};
static const tumble_lent_t LENT = {.estimator = TUMBLE_ESTIMATE_OPTIMAL,
                                   .check = tumble_optimal_check,
                                   .estimate = tumble_optimal_estimate,
                                   .source = &SOURCE};

const tumble_lent_t *zcu102_lent(void)
{
    return &LENT;
}
#else
const tumble_lent_t *zcu102_lent(void)
{
    return NULL;
}
#endif
