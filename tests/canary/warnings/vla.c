/* Defect: an array whose size is known only at run time. */
int canary_vla(int count);

int canary_vla(int count)
{
    volatile int array[count];
    array[0] = count;
    return array[0];
}
