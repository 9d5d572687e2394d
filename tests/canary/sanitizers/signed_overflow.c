/* Adds its argument to the largest int: 1 and more overflow. */
#include <limits.h>
#include <stdlib.h>

int main(int count, char **arguments)
{
    volatile int sum = INT_MAX;
    sum = sum + ((count > 1) ? atoi(arguments[1]) : 0);
    return (sum == INT_MAX) ? 0 : 1;
}
