#include "processor.h"

#include "io.h"
#include "uart.h"

#define DISTRIBUTOR 0xF9010000U
#define INTERFACE 0xF9020000U
#define TIMER_INTERRUPT 30U /* of the processor itself */
#define US_PER_S 1000000U
#define LONGEST_SLEEP_US US_PER_S
#define SEMIHOSTING_EXIT 0x18U
#define SEMIHOSTING_APPLICATION_EXIT 0x20026U
#define EXIT_ON_FAULT 99

static void enable(uint32_t interrupt)
{
    const uint32_t word = 4U * (interrupt / 32U);
    const uint32_t bit = 1U << (interrupt % 32U);
    const uint32_t targets = DISTRIBUTOR + 0x800U + (interrupt & ~3U);
    zcu102_write(targets, zcu102_read(targets) | (1U << (8U * (interrupt % 4U)))); /* this processor */
    zcu102_write(DISTRIBUTOR + 0x100U + word, bit);
}

void zcu102_wake_by(uint32_t interrupt)
{
    zcu102_write(DISTRIBUTOR, 3U); /* both groups */
    zcu102_write(INTERFACE + 4U, 0xFFU);
    zcu102_write(INTERFACE, 3U);
    enable(TIMER_INTERRUPT);
    enable(interrupt);
}

static uint64_t frequency_hz(void)
{
    uint64_t value;
    __asm__ volatile("mrs %0, cntfrq_el0" : "=r"(value));
    return value;
}

uint64_t zcu102_now_us(void)
{
    uint64_t ticks;
    const uint64_t hz = frequency_hz();
    __asm__ volatile("isb\n mrs %0, cntpct_el0" : "=r"(ticks)::"memory");
    return ((ticks / hz) * US_PER_S) + (((ticks % hz) * US_PER_S) / hz);
}

/* The timer's comparison, in ticks, rounded up. */
static void set_alarm(uint64_t moment_us)
{
    const uint64_t hz = frequency_hz();
    const uint64_t ticks = ((moment_us / US_PER_S) * hz) + ((((moment_us % US_PER_S) * hz) / US_PER_S) + 1U);
    __asm__ volatile("msr cntp_cval_el0, %0\n msr cntp_ctl_el0, %1\n isb" ::"r"(ticks), "r"(UINT64_C(1)));
}

void zcu102_sleep_until(uint64_t moment_us)
{
    const uint64_t now_us = zcu102_now_us();
    if (moment_us <= now_us) {
        return;
    }
    set_alarm((moment_us - now_us < LONGEST_SLEEP_US) ? moment_us : (now_us + LONGEST_SLEEP_US));
    __asm__ volatile("dsb sy\n wfi" ::: "memory"); /* interrupts are masked, but wake */
    __asm__ volatile("msr cntp_ctl_el0, xzr\n isb");
}

_Noreturn void zcu102_exit(int code)
{
    const uint64_t block[2] = {SEMIHOSTING_APPLICATION_EXIT, (uint64_t)(unsigned)code};
    register uint64_t operation __asm__("x0") = SEMIHOSTING_EXIT;
    register const uint64_t *argument __asm__("x1") = block;
    __asm__ volatile("hlt #0xf000" ::"r"(operation), "r"(argument) : "memory");
    for (;;) {
        __asm__ volatile("wfi");
    }
}

/* From start.S. */
_Noreturn void zcu102_fault(uint64_t syndrome, uint64_t address);

_Noreturn void zcu102_fault(uint64_t syndrome, uint64_t address)
{
    static int faults;
    faults++;
    if (faults == 1) { /* without semihosting the exit itself is an exception */
        zcu102_put("fault: syndrome ");
        zcu102_put_hex(syndrome, 8);
        zcu102_put(" at ");
        zcu102_put_hex(address, 16);
        zcu102_put("\r\n");
        zcu102_exit(EXIT_ON_FAULT);
    }
    for (;;) {
        __asm__ volatile("wfi");
    }
}
