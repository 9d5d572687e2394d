/* store_codec_harness.c - one record from stdin, decoded by the firmware: its numbers on stdout, a line each, doubles in
 * hexadecimal; then the same record as the firmware writes it, in hexadecimal digits. The temperature range of a
 * position is that of the set of a run which ends with it; it has no numbers where it is not known.
 *
 *     store_codec set|entry|run|position [FINGERPRINT]
 */
#include "flash.h"
#include "tumble/sets.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

static uint8_t bytes[512];

static void print_doubles(const char *name, const double *values, int count)
{
    (void)printf("%s", name);
    for (int i = 0; i < count; i++) {
        (void)printf(" %a", values[i]);
    }
    (void)printf("\n");
}

static void print_floats(const char *name, const float *values, int count)
{
    (void)printf("%s", name);
    for (int i = 0; i < count; i++) {
        (void)printf(" %a", (double)values[i]);
    }
    (void)printf("\n");
}

static int print_bytes(const uint8_t *written, size_t size)
{
    for (size_t i = 0; i < size; i++) {
        (void)printf("%02x", written[i]);
    }
    (void)printf("\n");
    return 0;
}

static int print_set(void)
{
    tumble_set_t set;
    tumble_thermal_t thermal;
    const tumble_status_t status = tumble_set_decode_thermal(bytes, &set, &thermal);
    if (status != TUMBLE_OK) {
        return (int)status;
    }
    const bool has_slopes = (set.flags & TUMBLE_SET_HAS_SLOPES) != 0U;
    const double check[] = {set.max_abs_fit_g, set.max_abs_check_g, set.limit_g};
    (void)printf("sequence %" PRIu32 "\norigin %u\nestimator %u\nflags %u\n", set.sequence, set.origin, set.estimator,
                 set.flags);
    (void)printf("serial ");
    (void)print_bytes(set.block_serial, sizeof set.block_serial);
    (void)printf("date_utc_s %" PRIu64 "\n", set.date_utc_s);
    print_doubles("temperature_c", &set.temperature_c, 1);
    print_doubles("gravity_m_s2", &set.gravity_m_s2, 1);
    print_doubles("k", set.coefficients.k_v_per_g[0], 9);
    print_doubles("u0", set.coefficients.u0_v, 3);
    print_doubles("u_k", set.uncertainty.k_v_per_g[0], 9);
    print_doubles("u_u0", set.uncertainty.u0_v, 3);
    print_doubles("check", check, 3);
    print_doubles("closure_v", &set.closure_v, 1);
    (void)printf("samples %" PRIu32 "\nfit_positions %u\ncheck_positions %u\n", set.samples, set.fit_positions,
                 set.check_positions);
    (void)printf("schedule_crc %" PRIu32 "\nstand_crc %" PRIu32 "\nreasons %" PRIu32 "\n", set.schedule_crc,
                 set.stand_crc, set.reasons);
    (void)printf("restores %" PRIu32 "\nfrom_crc %" PRIu32 "\n", set.restores, set.from_crc);
    const double range_c[] = {set.temperature_min_half_c / 2.0, set.temperature_max_half_c / 2.0};
    print_doubles("temperature_range_c", range_c, 2);
    double slopes[2 * TUMBLE_COEFFICIENTS];
    memcpy(slopes, &thermal.power[1], sizeof slopes);
    print_doubles("slopes", slopes, has_slopes ? 2 * TUMBLE_COEFFICIENTS : 0);
    const tumble_status_t written =
        has_slopes ? tumble_set_encode_thermal(&set, &thermal, bytes) : tumble_set_encode(&set, bytes);
    return (written == TUMBLE_OK) ? print_bytes(bytes, TUMBLE_SET_BYTES) : 1;
}

static int print_entry(void)
{
    tumble_history_entry_t entry;
    const tumble_status_t status = tumble_history_decode(bytes, &entry);
    if (status != TUMBLE_OK) {
        return (int)status;
    }
    (void)printf("number %" PRIu32 "\nsequence %" PRIu32 "\norigin %u\nestimator %u\nflags %u\ndate_utc_s %" PRIu64
                 "\n",
                 entry.number, entry.sequence, entry.origin, entry.estimator, entry.flags, entry.date_utc_s);
    print_floats("temperature_c", &entry.temperature_c, 1);
    print_floats("values", entry.value, TUMBLE_COEFFICIENTS);
    print_floats("u", entry.u, TUMBLE_COEFFICIENTS);
    return (tumble_history_encode(&entry, bytes) == TUMBLE_OK) ? print_bytes(bytes, TUMBLE_HISTORY_BYTES) : 1;
}

static nv_memory_t memory;
static tumble_checkpoint_t checkpoint;

static int settle(void)
{
    tumble_status_t status = TUMBLE_E_PORT_BUSY;
    while (status == TUMBLE_E_PORT_BUSY) {
        status = tumble_checkpoint_step(&checkpoint);
    }
    return (int)status;
}

/* The range that a run with these margins gives its set. */
static void print_range(tumble_margins_t margins)
{
    tumble_set_t set = {.flags = 0};
    tumble_margins_range(&margins, &set);
    const double range_c[] = {set.temperature_min_half_c / 2.0, set.temperature_max_half_c / 2.0};
    print_doubles("temperature_range_c", range_c, ((set.flags & TUMBLE_SET_HAS_TEMPERATURE_RANGE) != 0U) ? 2 : 0);
}

/* Through the memory: begun and appended by the firmware, then the given bytes in their place, read by it. */
static int print_checkpoint(uint32_t fingerprint, bool position)
{
    uint8_t *const cell = &memory.bytes[(6U * 4096U) + (position ? TUMBLE_CHECKPOINT_BYTES : 0U)];
    tumble_average_t average = {.samples = 1};
    const uint8_t index = bytes[2];
    nv_make(&memory, TUMBLE_REGION_COUNT, 8, 4096);
    if (tumble_checkpoint_init(&checkpoint, &memory.nv) != TUMBLE_OK || settle() != 0 ||
        tumble_checkpoint_begin(&checkpoint, fingerprint) != TUMBLE_OK || settle() != 0) {
        return 1;
    }
    if (!position) {
        return print_bytes(cell, TUMBLE_CHECKPOINT_BYTES);
    }
    memcpy(cell, bytes, TUMBLE_CHECKPOINT_BYTES);
    if (tumble_checkpoint_init(&checkpoint, &memory.nv) != TUMBLE_OK || settle() != 0) {
        return 1;
    }
    checkpoint.margins = (tumble_margins_t){UINT8_MAX, UINT8_MAX};
    if (tumble_checkpoint_read(&checkpoint, index, &average) != TUMBLE_OK) {
        return 1;
    }
    (void)printf("index %u\nsamples %" PRIu32 "\nsums %" PRId64 " %" PRId64 " %" PRId64 "\n", index, average.samples,
                 average.sum_counts[0], average.sum_counts[1], average.sum_counts[2]);
    print_floats("scatter", average.scatter_counts, 3);
    print_range(checkpoint.margins);
    if (tumble_checkpoint_append(&checkpoint, index, &average) != TUMBLE_OK || settle() != 0) {
        return 1;
    }
    return print_bytes(cell + TUMBLE_CHECKPOINT_BYTES, TUMBLE_CHECKPOINT_BYTES);
}

int main(int count, char **arguments)
{
    const char *kind = (count > 1) ? arguments[1] : "";
    const uint32_t fingerprint = (count > 2) ? (uint32_t)strtoul(arguments[2], NULL, 0) : 0U;
    (void)fread(bytes, 1, sizeof bytes, stdin);
    if (strcmp(kind, "set") == 0) {
        return print_set();
    }
    return (strcmp(kind, "entry") == 0) ? print_entry() : print_checkpoint(fingerprint, strcmp(kind, "position") == 0);
}
