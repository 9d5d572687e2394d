/* Defect: a declaration that does not say what the function takes. */
int canary_prototype();

int canary_prototype(void)
{
    return 1;
}
