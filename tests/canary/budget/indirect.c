/* Defect: a call through a pointer that anyone may set. */
int canary_call(int (*function)(int), int value);

int canary_call(int (*function)(int), int value)
{
    return function(value) + 1;
}
