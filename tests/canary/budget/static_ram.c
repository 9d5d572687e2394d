/* Defect: a hidden buffer as large as the whole limit of static RAM. */
unsigned char *canary_buffer(void);

unsigned char *canary_buffer(void)
{
    static unsigned char buffer[1536];
    return buffer;
}
