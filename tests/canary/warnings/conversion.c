/* Defect: an int squeezed into eight bits. */
#include <stdint.h>

uint8_t canary_conversion(int value);

uint8_t canary_conversion(int value)
{
    return value;
}
