/* start.c - from reset to main on a Cortex-M4 with its floating point unit. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

extern uint32_t stack_top[], data_in_flash[], data_begin[], data_end[], bss_begin[], bss_end[];
int main(void);
void initialise_monitor_handles(void); /* of newlib: standard output through the debugger */
void reset(void);
_Noreturn void go_on(void);

static void fault(void)
{
    for (;;) {
        __asm volatile("bkpt 1");
    }
}

__attribute__((section(".vectors"), used)) static void (*const vectors[16])(void) = {
    (void (*)(void))stack_top,
    reset,
    [2 ... 15] = fault,
};

_Noreturn void go_on(void)
{
    memcpy(data_begin, data_in_flash, (size_t)((uintptr_t)data_end - (uintptr_t)data_begin));
    memset(bss_begin, 0, (size_t)((uintptr_t)bss_end - (uintptr_t)bss_begin));
    initialise_monitor_handles();
    exit(main());
}

/* Without a prologue, which could use the floating point unit before CPACR has switched it on. */
__attribute__((naked)) void reset(void)
{
    __asm volatile(
        "ldr r0, =0xE000ED88\n"
        "ldr r1, [r0]\n"
        "orr r1, r1, #(0xF << 20)\n"
        "str r1, [r0]\n"
        "dsb\n"
        "isb\n"
        "b go_on\n"
        ".ltorg\n");
}
