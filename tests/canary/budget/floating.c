/* Defect: a function of the sample path that takes a mean, which it leaves to another one. */
int canary_mean(int sum, int count);
int canary_floating(int sum, int count);

int canary_mean(int sum, int count)
{
    return (int)((double)sum / (double)count);
}

int canary_floating(int sum, int count)
{
    return (count > 0) ? canary_mean(sum, count) : 0;
}
