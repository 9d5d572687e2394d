/* errno.c - the square root of newlib's libm sets errno. One word of the board's own serves it instead of the
 * reentrancy block that newlib would bring along (96 bytes and more).
 */
int *__errno(void);

int *__errno(void)
{
    static int number;
    return &number;
}
