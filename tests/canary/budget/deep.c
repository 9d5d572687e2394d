/* Defect: a local array larger than the whole limit of navcomp's call chain. */
int canary_deep(int seed);

int canary_deep(int seed)
{
    volatile int array[500];
    for (int i = 0; i < 500; i++) {
        array[i] = seed + i;
    }
    return array[seed & 127];
}
