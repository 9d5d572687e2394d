/* measure.h - what one call takes on the target: stack, painted below the caller and read back, and ticks of a 25 MHz clock.
 * With QEMU's -icount shift=0 an instruction takes 1 ns, so a tick is 40 instructions; without it ticks mean nothing.
 */
#ifndef TUMBLE_TESTS_TARGET_MEASURE_H
#define TUMBLE_TESTS_TARGET_MEASURE_H

#include <stdint.h>

typedef struct {
    uint32_t stack_bytes; /* below the call: its own frame and everything under it */
    uint32_t ticks;
} taken_t;

taken_t measure(void (*call)(void));

void put(const char *text);
void put_decimal(uint32_t number);

#endif
