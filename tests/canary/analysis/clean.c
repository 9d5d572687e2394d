/* No defect. */
#include <stddef.h>
#include <stdint.h>

extern int32_t canary_mean(const int32_t *values, int32_t count);

int32_t canary_mean(const int32_t *values, int32_t count)
{
    int32_t mean = 0;
    if ((values != NULL) && (count > 0)) {
        mean = (values[0] / 2) + (values[count - 1] / 2);
    }
    return mean;
}
