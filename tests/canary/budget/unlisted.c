/* Defect: a function whose address lies in a table, where a call through a pointer may find it. */
int canary_unlisted(int value);
extern int (*const canary_table[1])(int);

int canary_unlisted(int value)
{
    return value + 1;
}

int (*const canary_table[1])(int) = {canary_unlisted};
