/* rows.c - rows of CSV as numbers; part of the extension's source.
 *
 * rows_parse is the inner loop of tumble.files.rows: it takes the lines that are plain (numbers that one division or product makes exact, no quotes, no comments, a
 * position of the schedule) and stops at any other, which RowParser reads and alone may refuse. Rows are ux, uy, uz, the number of the line, then time and temperature.
 */
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

enum { ROWS_OUTPUTS = 3, ROWS_MOUNTING = 3, ROWS_POSITION, ROWS_TIME, ROWS_TEMPERATURE, ROWS_WANTED };
enum { ROWS_LONGEST_NOTE = 4096 };

/* How lines are laid out. `role` (columns): which of ux, uy, uz, mounting, position, time, temperature (0 to 6) a column
 * is, or negative. `position` (256 x 256): index of a position by the numbers of mounting and position, negative: none;
 * NULL where rows have no position. `width` of a row that is written: 4, or 6 with time and temperature. Temperatures
 * outside coldest to hottest are not plain. */
typedef struct {
    char delimiter;
    char decimal;
    uint32_t columns;
    uint32_t width;
    const int8_t *role;
    const int32_t *position;
    double coldest;
    double hottest;
} rows_layout_t;

/* What was found: bytes, rows, blank lines among them; whether a number had a decimal mark; the range of the
 * temperatures, which the caller sets before to +-infinity. */
typedef struct {
    size_t bytes;
    size_t rows;
    size_t blanks;
    bool marked;
    double low_c;
    double high_c;
} rows_found_t;

/* A number as it is written: digits * 10^exponent. */
typedef struct {
    uint64_t digits;
    int exponent;
    bool negative;
    bool marked;
} rows_decimal_t;

static bool rows_is_digit(char sign)
{
    return sign >= '0' && sign <= '9';
}

/* Digits up to what is none, appended to those before; NULL where there are too many. */
static const char *rows_digits(const char *at, uint64_t *digits)
{
    for (; rows_is_digit(*at); at++) {
        if (*digits > (UINT64_MAX - 9U) / 10U) {
            return NULL;
        }
        *digits = 10U * *digits + (uint64_t)(*at - '0');
    }
    return at;
}

static const char *rows_exponent(const char *at, int *exponent)
{
    const bool negative = *at == '-';
    uint64_t digits = 0;
    at += *at == '-' || *at == '+';
    const char *end = rows_digits(at, &digits);
    if (end == NULL || end == at || digits > 999U) {
        return NULL;
    }
    *exponent += negative ? -(int)digits : (int)digits;
    return end;
}

/* A number before any other sign; NULL: there is none, or it is not plain. */
static const char *rows_decimal(const char *at, char mark, rows_decimal_t *found)
{
    *found = (rows_decimal_t){.negative = *at == '-'};
    at += *at == '-' || *at == '+';
    const char *begin = at;
    at = rows_digits(at, &found->digits);
    ptrdiff_t count = at == NULL ? 0 : at - begin;
    if (at != NULL && *at == mark) {
        found->marked = true;
        begin = at + 1;
        at = rows_digits(begin, &found->digits);
        found->exponent = at == NULL ? 0 : (int)(begin - at);
        count -= found->exponent;
    }
    if (at == NULL || count == 0) {
        return NULL;
    }
    return *at == 'e' || *at == 'E' ? rows_exponent(at + 1, &found->exponent) : at;
}

#if FLT_EVAL_METHOD == 0 && defined(__SIZEOF_INT128__)
static int rows_bits(uint64_t value)
{
    return 64 - __builtin_clzll(value);
}

/* digits / divisor, neither 0, rounded once: the quotient has 63 or 64 bits and a remainder that decides ties. */
static double rows_quotient(uint64_t digits, uint64_t divisor)
{
    const int shift = 63 - rows_bits(digits) + rows_bits(divisor);
    const unsigned __int128 dividend = (unsigned __int128)digits << shift;
    const uint64_t quotient = (uint64_t)(dividend / divisor);
    const bool is_exact = (unsigned __int128)quotient * divisor == dividend;
    const int spare = rows_bits(quotient) - DBL_MANT_DIG;
    const uint64_t half = UINT64_C(1) << (spare - 1);
    const uint64_t rest = quotient & (2U * half - 1U);
    uint64_t kept = quotient >> spare;
    kept += rest > half || (rest == half && (!is_exact || (kept & 1U) != 0U));
    return ldexp((double)kept, spare - shift);
}

/* The double next to the number; false where it would take more than one operation. */
static bool rows_value(const rows_decimal_t *number, double *value)
{
    static const double powers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    const int exponent = number->exponent;
    double size = (double)number->digits;
    if (number->digits <= UINT64_C(1) << DBL_MANT_DIG && exponent >= -22 && exponent <= 22) {
        size = exponent < 0 ? size / powers[-exponent] : size * powers[exponent];
    } else if (exponent < 0 && exponent >= -19) {
        size = rows_quotient(number->digits, (uint64_t)powers[-exponent]);
    } else if (number->digits != 0U) {
        return false;
    }
    *value = number->negative ? -size : size;
    return true;
}
#else /* without exact arithmetic no line is plain */
static bool rows_value(const rows_decimal_t *number, double *value)
{
    (void)number;
    (void)value;
    return false;
}
#endif

static const char *rows_blanks(const char *at, char delimiter)
{
    while (*at == ' ' && delimiter != ' ') {
        at++;
    }
    return at;
}

/* Over a field that is not looked at. */
static const char *rows_note(const char *at, char delimiter)
{
    const char *const begin = at;
    while (*at != delimiter && *at != '\n' && *at != '\r') {
        if (*at == '"' || at - begin > ROWS_LONGEST_NOTE) {
            return NULL;
        }
        at++;
    }
    return at;
}

/* One number of a line. An empty temperature is NAN. */
static const char *rows_field(const rows_layout_t *layout, int role, const char *at, rows_found_t *found, double *value)
{
    rows_decimal_t number;
    at = rows_blanks(at, layout->delimiter);
    if (role == ROWS_TEMPERATURE && (*at == layout->delimiter || *at == '\n' || *at == '\r')) {
        *value = NAN;
        return at;
    }
    at = rows_decimal(at, layout->decimal, &number);
    if (at == NULL || !rows_value(&number, value)) {
        return NULL;
    }
    found->marked |= number.marked && role < ROWS_TIME;
    return rows_blanks(at, layout->delimiter);
}

/* A line's wanted numbers, by role; NULL where it is not plain, else what follows its end. */
static const char *rows_line(const rows_layout_t *layout, const char *at, rows_found_t *found, double *values)
{
    if (*at == '#') {
        return NULL;
    }
    for (uint32_t column = 0; column < layout->columns; column++) {
        const int role = layout->role[column];
        at = role < 0 ? rows_note(at, layout->delimiter) : rows_field(layout, role, at, found, &values[role]);
        const bool is_last = column + 1U == layout->columns;
        if (at != NULL && is_last && *at == '\r') {
            at++;
        }
        if (at == NULL || *at != (is_last ? '\n' : layout->delimiter)) {
            return NULL;
        }
        at++;
    }
    return at;
}

/* The index of a row's position, 0 where rows have none; negative where its numbers, or an output or the temperature,
 * are not plain. */
static int32_t rows_index(const rows_layout_t *layout, const double *values)
{
    for (int channel = 0; channel < ROWS_OUTPUTS; channel++) {
        if (!(fabs(values[channel]) <= TUMBLE_MAX_MEAN_V)) {
            return -1;
        }
    }
    const double celsius = values[ROWS_TEMPERATURE];
    if (celsius < layout->coldest || celsius > layout->hottest) {
        return -1;
    }
    if (layout->position == NULL) {
        return 0;
    }
    const double mounting = values[ROWS_MOUNTING];
    const double position = values[ROWS_POSITION];
    const bool in_table = mounting >= 0.0 && mounting <= 255.0 && position >= 0.0 && position <= 255.0;
    if (!in_table || floor(mounting) != mounting || floor(position) != position) {
        return -1;
    }
    return layout->position[256 * (int)mounting + (int)position];
}

/* Lines from the beginning of `text` up to the first that is not plain; the last byte is a line end. `line`: the number
 * of the first. `index` (rows) and `rows` (rows x width) hold size / 6 rows, size / 10 where rows have a position. */
void rows_parse(const rows_layout_t *layout, const char *text, size_t size, double line, uint16_t *index, double *rows,
                rows_found_t *found)
{
    const char *at = text;
    const char *const end = text + size;
    double values[ROWS_WANTED];
    values[ROWS_TIME] = values[ROWS_TEMPERATURE] = NAN;
    found->rows = found->blanks = 0;
    for (; at < end; line += 1.0) {
        if (*at == '\n' || (*at == '\r' && at[1] == '\n')) {
            at += *at == '\n' ? 1 : 2;
            found->blanks++;
            continue;
        }
        const bool marked = found->marked;
        const char *const next = rows_line(layout, at, found, values);
        const int32_t position = next == NULL ? -1 : rows_index(layout, values);
        if (position < 0) {
            found->marked = marked;
            break;
        }
        at = next;
        index[found->rows++] = (uint16_t)position;
        memcpy(rows, values, ROWS_OUTPUTS * sizeof values[0]);
        rows[ROWS_OUTPUTS] = line;
        if (layout->width > ROWS_OUTPUTS + 1U) {
            rows[ROWS_OUTPUTS + 1] = values[ROWS_TIME];
            rows[ROWS_OUTPUTS + 2] = values[ROWS_TEMPERATURE];
        }
        rows += layout->width;
        found->low_c = fmin(found->low_c, values[ROWS_TEMPERATURE]);
        found->high_c = fmax(found->high_c, values[ROWS_TEMPERATURE]);
    }
    found->bytes = (size_t)(at - text);
}

/* Standard deviation of each channel (n - 1), of two rows or more; summed in their order. */
void rows_scatter(const double (*rows)[4], size_t number, double *scatter)
{
    for (int channel = 0; channel < ROWS_OUTPUTS; channel++) {
        double sum = 0.0;
        for (size_t row = 0; row < number; row++) {
            sum += rows[row][channel];
        }
        const double mean = sum / (double)number;
        double squares = 0.0;
        for (size_t row = 0; row < number; row++) {
            const double off = rows[row][channel] - mean;
            squares += off * off;
        }
        scatter[channel] = sqrt(squares / (double)(number - 1U));
    }
}

/* Sums of squares of neighbouring blocks of 1, 2, 4, ... rows, as tumble.files.run_file.Blocks defines them: a row of
 * `squares` for each length. `sums` holds number / 2 rows. */
void rows_squares(const double (*rows)[4], size_t number, double (*sums)[ROWS_OUTPUTS], double (*squares)[ROWS_OUTPUTS])
{
    double length = 1.0;
    for (size_t blocks = number; blocks > 1U; blocks /= 2U, length *= 2.0, squares++) {
        const bool of_rows = blocks == number;
        double found[ROWS_OUTPUTS] = {0.0, 0.0, 0.0};
        for (size_t pair = 0; pair < blocks / 2U; pair++) {
            for (int channel = 0; channel < ROWS_OUTPUTS; channel++) {
                const double origin = rows[0][channel];
                const double first = of_rows ? rows[2U * pair][channel] - origin : sums[2U * pair][channel];
                const double second = of_rows ? rows[2U * pair + 1U][channel] - origin : sums[2U * pair + 1U][channel];
                found[channel] += (first - second) * (first - second);
                sums[pair][channel] = first + second;
            }
        }
        for (int channel = 0; channel < ROWS_OUTPUTS; channel++) {
            squares[0][channel] = found[channel] / (2.0 * length);
        }
    }
}
