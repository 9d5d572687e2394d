/* No defect: the same as its neighbours, written as the warnings want it. */
#include <stdint.h>

uint8_t canary_clean(float value, int count);

uint8_t canary_clean(float value, int count)
{
    return (uint8_t)((int)((double)value * 0.5) + count);
}
