/* Defect: constants as large as the whole limit of code. */
extern const unsigned char canary_table[12288];

const unsigned char canary_table[12288] = {1};
