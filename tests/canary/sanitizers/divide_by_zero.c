/* Divides one by its argument, as doubles. */
#include <stdlib.h>

int main(int count, char **arguments)
{
    volatile double quotient = 1.0 / ((count > 1) ? atof(arguments[1]) : 1.0);
    return (quotient > 0.0) ? 0 : 1;
}
