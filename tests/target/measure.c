#include "measure.h"

#include "target.h"

#define PAINT 0xA5A5A5A5U
#define PAINTED_WORDS 2048U
#define SYSTICK ((volatile uint32_t *)0xE000E010)

/* Only leaf code between the painting and the reading: the stack pointer is the same in all of it. */
taken_t measure(void (*call)(void))
{
    uint32_t *top;
    __asm__ volatile("mov %0, sp" : "=r"(top));
    volatile uint32_t *const bottom = top - PAINTED_WORDS;
    for (volatile uint32_t *word = bottom; word < top; word++) {
        *word = PAINT;
    }
    SYSTICK[1] = 0xFFFFFFU;
    SYSTICK[0] = 5; /* on, processor clock, no interrupt */
    SYSTICK[2] = 0;
    const uint32_t before = SYSTICK[2];
    call();
    const uint32_t after = SYSTICK[2];
    volatile uint32_t *used = bottom;
    while ((used < top) && (*used == PAINT)) {
        used++;
    }
    return (taken_t){(uint32_t)((uintptr_t)top - (uintptr_t)used), (before - after) & 0xFFFFFFU};
}

void put(const char *text)
{
    for (; *text != '\0'; text++) {
        target_put(*text);
    }
}

void put_decimal(uint32_t number)
{
    if (number >= 10U) {
        put_decimal(number / 10U);
    }
    target_put((int)('0' + (number % 10U)));
}
