/* No defect: a small function that fits. */
int canary_clean(int value);

int canary_clean(int value)
{
    return value / 3;
}
