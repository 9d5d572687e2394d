/* processor.h - the processor's own: time, sleep, the end. */
#ifndef ZCU102_PROCESSOR_H
#define ZCU102_PROCESSOR_H

#include <stdint.h>

/* Let the timer and the interrupt of a device (its number at the interrupt controller) end a sleep. No handler is ever
 * entered: who wakes up looks for himself what there is to do. */
void zcu102_wake_by(uint32_t interrupt);

/* Microseconds since power-on, from the generic timer. */
uint64_t zcu102_now_us(void);

/* Sleep until a device that may wake us asks for it, but not beyond this moment. May return too early. */
void zcu102_sleep_until(uint64_t moment_us);

/* Leave for good. Under an emulator or a debugger (semihosting) with an exit code; alone, the processor stops. */
_Noreturn void zcu102_exit(int code);

#endif
