#include "gain_file.h"

#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

/* Of the largest record: rows of 3 x 36 doubles for twelve coefficients, two errors of the stand, six yaws and
 * seats. */
#define MAX_BYTES (240U + (24U * TUMBLE_MAX_POSITIONS * (14U + (3U * TUMBLE_MAX_YAWS))))

const char *bench_gain_file_read(const char *path, tumble_optimal_source_t *source)
{
    static _Alignas(double) uint8_t memory[MAX_BYTES + 1U];
    FILE *const file = fopen(path, "rb");
    if (file == NULL) {
        return strerror(errno);
    }
    errno = 0;
    const size_t size = fread(memory, 1, sizeof memory, file);
    const int trouble = (ferror(file) != 0) ? errno : 0;
    (void)fclose(file);
    if (trouble != 0) {
        return strerror(trouble);
    }
    if (size > MAX_BYTES) {
        return "larger than any gain record";
    }
    source->record = memory;
    source->record_bytes = size;
    return NULL;
}
