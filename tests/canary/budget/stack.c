/* Defect: a local array larger than the whole limit of the call chain. */
int canary_stack(int seed);

int canary_stack(int seed)
{
    volatile int array[160];
    for (int i = 0; i < 160; i++) {
        array[i] = seed + i;
    }
    return array[seed & 63];
}
