/* start.c - reset vector, faults, and the debugger's services. A fault ends the test with a status of its own. */
#include "target.h"

#include <stdint.h>

#define SYS_WRITEC 0x03
#define SYS_EXIT_EXTENDED 0x20
#define APPLICATION_EXIT 0x20026U
#define STATUS_OF_A_FAULT 99U

extern char stack_top[];

int main(void);
void reset(void);
void fault(void);

__attribute__((section(".vectors"), used)) static const void *const vectors[] = {
    stack_top,           (const void *)reset, (const void *)fault, (const void *)fault,
    (const void *)fault, (const void *)fault, (const void *)fault};

static void semihosting(int operation, const void *argument)
{
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
}

static void leave(uint32_t status)
{
    const uint32_t block[2] = {APPLICATION_EXIT, status};
    semihosting(SYS_EXIT_EXTENDED, block);
}

void reset(void)
{
    leave((uint32_t)main());
}

void fault(void)
{
    leave(STATUS_OF_A_FAULT);
}

void target_put(int character)
{
    const char byte = (char)character;
    semihosting(SYS_WRITEC, &byte);
}
