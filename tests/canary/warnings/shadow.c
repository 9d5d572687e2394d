/* Defect: an inner variable hides an outer one. */
int canary_shadow(int value);

int canary_shadow(int value)
{
    for (int i = 0; i < 3; i++) {
        int value = i;
        (void)value;
    }
    return value;
}
