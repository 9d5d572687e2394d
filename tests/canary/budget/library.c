/* Defect: 64-bit division and single-precision division, which pull more of libgcc than the limit allows. */
#include <stdint.h>

int64_t canary_divide(int64_t dividend, int64_t divisor);
float canary_ratio(float dividend, float divisor);

int64_t canary_divide(int64_t dividend, int64_t divisor)
{
    return dividend / divisor;
}

float canary_ratio(float dividend, float divisor)
{
    return dividend / divisor * dividend + divisor;
}
