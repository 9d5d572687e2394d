/* gain_bench.h - gain records for the tests, laid down byte by byte as docs/files.md says, with a CRC-32 and a schedule
 * fingerprint of their own. They share no code with the reader.
 */
#ifndef TUMBLE_TESTS_UNIT_GAIN_BENCH_H
#define TUMBLE_TESTS_UNIT_GAIN_BENCH_H

#include "random_schedule.h"
#include "tumble/core.h"

#define GAIN_HEAD 232U
#define MOST_GAIN_BYTES (264U + 24U * TUMBLE_MAX_POSITIONS * (14U + TUMBLE_MAX_YAWS))

/* Numbers of the head, as doubles from byte 24 on. */
enum { AT_K = 0, AT_SIGMA = 9, AT_NOISE = 13, AT_U = 14, AT_GAINS = 26 };

typedef struct {
    _Alignas(8) uint8_t bytes[MOST_GAIN_BYTES];
    uint32_t size;
} gain_bytes_t;

/* By the book, highest bit first: reflect every byte, divide, reflect the remainder. */
static inline uint32_t reflect(uint32_t word, int bits)
{
    uint32_t reflected = 0;
    for (int i = 0; i < bits; i++) {
        reflected |= ((word >> i) & 1U) << (bits - 1 - i);
    }
    return reflected;
}

static inline uint32_t crc32_by_division(const uint8_t *bytes, size_t size)
{
    uint32_t remainder = 0xFFFFFFFFU;
    for (size_t i = 0; i < size; i++) {
        const uint32_t byte = reflect(bytes[i], 8);
        for (int bit = 7; bit >= 0; bit--) {
            const uint32_t out = (remainder >> 31) ^ ((byte >> bit) & 1U);
            remainder = (remainder << 1) ^ (out * 0x04C11DB7U);
        }
    }
    return reflect(remainder, 32) ^ 0xFFFFFFFFU;
}

static inline void put_word(uint8_t *to, uint32_t word)
{
    for (int i = 0; i < 4; i++) {
        to[i] = (uint8_t)(word >> (8 * i));
    }
}

static inline size_t put_double(uint8_t *to, double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    put_word(to, (uint32_t)bits);
    put_word(to + 4, (uint32_t)(bits >> 32));
    return 8;
}

static inline uint32_t fingerprint_of(const tumble_schedule_t *schedule)
{
    static uint8_t bytes[TUMBLE_MAX_MOUNTINGS * 82 + TUMBLE_MAX_POSITIONS * 10];
    size_t at = 0;
    for (unsigned m = 0; m < schedule->mounting_count; m++) {
        bytes[at++] = schedule->mountings[m].number;
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) {
                at += put_double(bytes + at, schedule->mountings[m].matrix[i][j] + 0.0);
            }
        }
        at += put_double(bytes + at, schedule->mountings[m].tilt.deg + 0.0);
        if (schedule->mountings[m].bolting > 0U) {
            bytes[at++] = schedule->mountings[m].bolting;
        }
    }
    for (unsigned p = 0; p < schedule->position_count; p++) {
        const tumble_position_t *position = &schedule->positions[p];
        if (position->use == TUMBLE_USE_FIT) {
            bytes[at++] = position->mounting;
            bytes[at++] = position->number;
            at += put_double(bytes + at, position->angle.deg + 0.0);
        }
    }
    return crc32_by_division(bytes, at);
}

static inline double number_at(const gain_bytes_t *record, unsigned index)
{
    double x;
    memcpy(&x, record->bytes + 24U + 8U * index, sizeof x);
    return x;
}

static inline void set_number(gain_bytes_t *record, unsigned index, double x)
{
    (void)put_double(record->bytes + 24U + 8U * index, x);
}

static inline void seal(gain_bytes_t *record)
{
    put_word(record->bytes + record->size - 4U, crc32_by_division(record->bytes, record->size - 4U));
}

/* A record for this schedule, every number zero but for the noise and a K that counts for nothing, sealed. */
static inline void empty_gains(const tumble_schedule_t *schedule, unsigned yaws, gain_bytes_t *record)
{
    const unsigned fit_positions = count_fit_positions(schedule);
    memset(record, 0, sizeof *record);
    record->size = 240U + 24U * fit_positions * (14U + yaws);
    memcpy(record->bytes, "TGR1", 4);
    put_word(record->bytes + 4, record->size);
    record->bytes[8] = 1;
    record->bytes[10] = (uint8_t)fit_positions;
    record->bytes[11] = schedule->mounting_count;
    record->bytes[12] = (uint8_t)yaws;
    put_word(record->bytes + 16, fingerprint_of(schedule));
    set_number(record, AT_K, 1e-30);
    set_number(record, AT_NOISE, 1e-4);
    seal(record);
}

/* Where the gain of a row and a column stands among the numbers. */
static inline unsigned gain_index(const tumble_schedule_t *schedule, unsigned row, unsigned column)
{
    return AT_GAINS + row * 3U * count_fit_positions(schedule) + column;
}

static inline const tumble_gain_record_t *open_gains(const gain_bytes_t *record, const tumble_schedule_t *schedule)
{
    const tumble_gain_record_t *opened = NULL;
    ASSERT_STATUS(TUMBLE_OK, tumble_gain_record_open(record->bytes, record->size, schedule, &opened));
    TEST_ASSERT_EQUAL_PTR(record->bytes, opened);
    return opened;
}

#endif
