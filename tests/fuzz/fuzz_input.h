/* fuzz_input.h - what the fuzz targets share: an input that is read byte by byte, and the invariants' one word.
 *
 * An input is a header and then records, one for every thing that happens, all of one size. What a record does not use
 * is skipped: so a record can be put in, taken out or changed (record_mutator.c) without any effect on what the others
 * mean. Each target defines both sizes for its own mutator.
 */
#ifndef TUMBLE_TESTS_FUZZ_INPUT_H
#define TUMBLE_TESTS_FUZZ_INPUT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

extern const size_t fuzz_header_bytes;
extern const size_t fuzz_record_bytes;

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

typedef struct {
    const uint8_t *data;
    size_t left;
} input_t;

static inline void require(bool holds, const char *what)
{
    if (!holds) {
        (void)fprintf(stderr, "violated: %s\n", what);
        abort();
    }
}

/* The next byte; 0 behind the end. */
static inline uint8_t take(input_t *input)
{
    uint8_t byte = 0;
    if (input->left > 0U) {
        byte = *input->data;
        input->data++;
        input->left--;
    }
    return byte;
}

/* The next `size` bytes as an input of their own, or as many as there are. */
static inline input_t cut(input_t *input, size_t size)
{
    const input_t piece = {input->data, (input->left < size) ? input->left : size};
    input->data += piece.left;
    input->left -= piece.left;
    return piece;
}

#endif
