/* Defect: one path divides by zero. */
#include <stdint.h>

extern int32_t canary_share(int32_t total, int32_t parts);

int32_t canary_share(int32_t total, int32_t parts)
{
    int32_t divisor = parts;
    if (parts < 3) {
        divisor = 0;
    }
    return total / divisor;
}
