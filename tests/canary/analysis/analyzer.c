/* Defect: one path reads through a null pointer. */
#include <stddef.h>
#include <stdint.h>

extern int32_t canary_first(const int32_t *values, int32_t count);

int32_t canary_first(const int32_t *values, int32_t count)
{
    const int32_t *first = values;
    if (count == 0) {
        first = NULL;
    }
    return *first;
}
