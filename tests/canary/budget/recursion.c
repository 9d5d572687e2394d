/* Defect: two functions that call each other, and not in tail position. */
int canary_even(int value);
int canary_odd(int value);

__attribute__((noinline)) int canary_odd(int value)
{
    return (value == 0) ? 0 : 3 * canary_even(value - 1) + 1;
}

__attribute__((noinline)) int canary_even(int value)
{
    return (value == 0) ? 1 : 5 * canary_odd(value - 1) + 1;
}
