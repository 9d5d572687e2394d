/* start.c - the reset vector, and the few services of the debugger (semihosting) that the benchmark needs. */
#include "benchmark.h"

extern char stack_top[];

int main(void);
void reset(void);

__attribute__((section(".vectors"), used)) static const void *const vectors[] = {stack_top, (const void *)reset};

static int semihosting(int operation, const void *argument)
{
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

void reset(void)
{
    (void)main();
    (void)semihosting(0x18, (const void *)0x20026); /* exit: the application is done */
}

void print(const char *text)
{
    (void)semihosting(0x04, text);
}

void print_hex(uint32_t word)
{
    char digits[10] = "00000000 ";
    for (int i = 7; i >= 0; i--) {
        digits[i] = "0123456789abcdef"[word & 15U];
        word >>= 4;
    }
    print(digits);
}
