#include "tumble/stand.h"

#include <string.h>

static double number_at(const uint8_t *at, uint8_t type)
{
    double number;
    int8_t whole;
    if (type == (uint8_t)TUMBLE_STAND_NUMBER_F64) {
        (void)memcpy(&number, at, sizeof number);
    } else {
        (void)memcpy(&whole, at, sizeof whole);
        number = (double)whole;
    }
    return number;
}

uint8_t tumble_stand_numbers(const tumble_stand_kind_t *kind, const void *profile, double *numbers)
{
    uint8_t count = 0;
    while ((count < TUMBLE_STAND_NUMBERS) && (kind->numbers[count].type != (uint8_t)TUMBLE_STAND_NUMBER_NONE)) {
        numbers[count] = number_at((const uint8_t *)profile + kind->numbers[count].at, kind->numbers[count].type);
        count++;
    }
    return count;
}
