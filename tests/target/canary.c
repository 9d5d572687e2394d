/* canary.c - a test that fails, and one that crashes: the emulator must end with a status that says so. */
int main(void)
{
#ifdef TUMBLE_CANARY_FAULT
    return *(volatile int *)0xF0000000U; /* nothing is there */
#else
    return 1;
#endif
}
