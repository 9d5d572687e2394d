/* How libFuzzer changes an input of records: it repeats, removes and exchanges whole records, or changes the bytes of
 * one of them. Its own byte-wise insertions would shift, and with that rewrite, everything behind them.
 */
#include "fuzz_input.h"

#include <string.h>

#define MAX_RECORD_BYTES 32U

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned int seed);

typedef struct {
    uint8_t *first;
    size_t count;
    size_t room;
} records_t;

static unsigned draw(unsigned *state)
{
    *state = (*state * 1664525U) + 1013904223U;
    return *state >> 8U;
}

static uint8_t *record(const records_t *records, size_t index)
{
    return &records->first[index * fuzz_record_bytes];
}

static void change(const records_t *records, size_t index)
{
    uint8_t bytes[MAX_RECORD_BYTES] = {0};
    memcpy(bytes, record(records, index), fuzz_record_bytes);
    (void)LLVMFuzzerMutate(bytes, fuzz_record_bytes, fuzz_record_bytes);
    memcpy(record(records, index), bytes, fuzz_record_bytes);
}

/* One byte behind the first, which tells what the record is. */
static void change_operand(const records_t *records, size_t index, unsigned *state)
{
    static const uint8_t edges[] = {0x00, 0x01, 0x7F, 0x80, 0xFF};
    uint8_t *operand = &record(records, index)[1U + (draw(state) % (fuzz_record_bytes - 1U))];
    switch (draw(state) % 3U) {
    case 0:
        *operand = (uint8_t)draw(state);
        break;
    case 1:
        *operand = (uint8_t)(*operand ^ (1U << (draw(state) % 8U)));
        break;
    default:
        *operand = edges[draw(state) % sizeof edges];
        break;
    }
}

/* A copy of the record at `from` (none: an empty one), put in before the one at `to`. */
static void insert(records_t *records, size_t from, size_t to)
{
    uint8_t bytes[MAX_RECORD_BYTES] = {0};
    if (from < records->count) {
        memcpy(bytes, record(records, from), fuzz_record_bytes);
    }
    memmove(record(records, to + 1U), record(records, to), (records->count - to) * fuzz_record_bytes);
    memcpy(record(records, to), bytes, fuzz_record_bytes);
    records->count++;
}

static void drop(records_t *records, size_t index)
{
    records->count--;
    memmove(record(records, index), record(records, index + 1U), (records->count - index) * fuzz_record_bytes);
}

static void exchange(const records_t *records, size_t a, size_t b)
{
    uint8_t bytes[MAX_RECORD_BYTES];
    memcpy(bytes, record(records, a), fuzz_record_bytes);
    memmove(record(records, a), record(records, b), fuzz_record_bytes);
    memcpy(record(records, b), bytes, fuzz_record_bytes);
}

static void mutate(records_t *records, unsigned *state)
{
    const unsigned kind = draw(state) % 10U;
    const size_t here = draw(state) % (records->count + 1U);
    const size_t there = draw(state) % (records->count + 1U);
    if ((kind < 2U) && (records->count < records->room)) {
        insert(records, there, here);
        change(records, here);
    } else if ((here == records->count) || (there == records->count)) {
        return;
    } else if (kind == 2U) {
        drop(records, here);
    } else if (kind == 3U) {
        exchange(records, here, there);
    } else if (kind < 8U) {
        change_operand(records, here, state);
    } else {
        change(records, here);
    }
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned int seed)
{
    unsigned state = seed;
    if ((max_size < (fuzz_header_bytes + fuzz_record_bytes)) || ((draw(&state) % 16U) == 0U)) {
        return LLVMFuzzerMutate(data, size, max_size); /* the header too, and inputs that end within a record */
    }
    if (size < fuzz_header_bytes) {
        memset(&data[size], 0, fuzz_header_bytes - size);
    }
    const size_t whole = (size > fuzz_header_bytes) ? ((size - fuzz_header_bytes) / fuzz_record_bytes) : 0U;
    records_t records = {&data[fuzz_header_bytes], whole, (max_size - fuzz_header_bytes) / fuzz_record_bytes};
    for (unsigned times = 1U + (draw(&state) % 6U); times > 0U; times--) {
        mutate(&records, &state);
    }
    return fuzz_header_bytes + (records.count * fuzz_record_bytes);
}
