"""What takes K2 and K3 out, in other languages: Newton's method of model.force, PASSES times, never more nor less.

    a <- a - J^-1 (F(a) - (U - U0)),   from a = K^-1 (U - U0)

J^-1 by the adjugate of J. Outputs that no acceleration gives, beyond a maximum of F, come out as nonsense, where
`tumble apply` refuses them.
"""

from __future__ import annotations

from tumble.model.force import PASSES
from tumble.terms import POWERS, Terms

_IN_C = """
/* The specific force that outputs show: {passes} passes of Newton's method. Outputs that no force gives, because K2
 * or K3 turn them back before, give nonsense. */
static inline void tumble_exported_force(const {number} outputs[3], {number} force[3])
{{
    static const {number} k[3][3] = {{ {rows} }};
    static const {number} inverse[3][3] = TUMBLE_K_INVERSE_INITIALIZER;
    const {number} shown[3] = {{ {biases} }};
    for (int i = 0; i < 3; i++) {{
        force[i] = inverse[i][0] * shown[0] + inverse[i][1] * shown[1] + inverse[i][2] * shown[2];
    }}
    for (int n = 0; n < {passes}; n++) {{
        {number} slope[3][3], over[3];
        for (int i = 0; i < 3; i++) {{
            over[i] = k[i][0] * force[0] + k[i][1] * force[1] + k[i][2] * force[2] - shown[i];
            for (int j = 0; j < 3; j++) {{
                slope[i][j] = k[i][j];
            }}
        }}
{beyond}
        {number} determinant = 0, moved[3] = {{ 0, 0, 0 }};
        for (int i = 0; i < 3; i++) {{
            for (int j = 0; j < 3; j++) {{
                const int a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
                const {number} adjugate = slope[c][a] * slope[d][b] - slope[c][b] * slope[d][a];
                moved[i] += adjugate * over[j];
                determinant += j == 0 ? slope[0][i] * adjugate : 0;
            }}
        }}
        for (int i = 0; i < 3; i++) {{
            force[i] -= moved[i] / determinant;
        }}
    }}
}}
"""


def in_c(terms: Terms, number: str, biases: str) -> str:
    """A function of the C header; `number`: double or float; `biases`: outputs less U0, as an initializer."""
    rows = ", ".join(f"{{ {', '.join(f'TUMBLE_K_{i}{j}' for j in 'XYZ')} }}" for i in "XYZ")
    lines = []
    for i, axis in enumerate("XYZ"):
        force, own = f"force[{i}]", f"TUMBLE_K_{axis * 2}"
        sizes = [(POWERS[term], f"TUMBLE_{term.upper()}_{axis}") for term in terms]
        beyond = " + ".join(" * ".join([size, *[force] * power]) for power, size in sizes)
        slope = " + ".join(" * ".join([str(power), size, *[force] * (power - 1)]) for power, size in sizes)
        lines += [f"        over[{i}] += {own} * ({beyond});", f"        slope[{i}][{i}] += {own} * ({slope});"]
    return _IN_C.format(number=number, biases=biases, rows=rows, beyond="\n".join(lines), passes=PASSES)


def in_matlab(terms: Terms) -> list[str]:
    """Lines of a script that has set `tumble.K` and the like; samples are rows. J column by column, so that all samples
    are solved at once."""
    beyond = " + ".join(f"tumble.{term.upper()}' .* a.^{POWERS[term]}" for term in terms)
    slope = " + ".join(f"{POWERS[term]} .* tumble.{term.upper()}' .* a.^{POWERS[term] - 1}" for term in terms)
    root = "(U - tumble.U0') * tumble.K_inverse'"
    for _ in range(PASSES):
        root = f"tumble_step({root}, U - tumble.U0')"
    columns = ", ".join(f"tumble_column(a, {j})" for j in (1, 2, 3))
    return [
        f"tumble_over = @(a, left) a * tumble.K' + diag(tumble.K)' .* ({beyond}) - left;",
        f"tumble_slope = @(a) diag(tumble.K)' .* ({slope});",
        "tumble_column = @(a, j) tumble.K(:, j)' + tumble_slope(a) .* ((1:3) == j);",
        "tumble_triple = @(x, y, z) dot(x, cross(y, z, 2), 2);",
        "tumble_solved = @(x, y, z, r) [tumble_triple(r, y, z), tumble_triple(x, r, z), tumble_triple(x, y, r)]"
        " ./ tumble_triple(x, y, z);",
        f"tumble_step = @(a, left) a - tumble_solved({columns}, tumble_over(a, left));",
        f"tumble.apply = @(U) {root};",
    ]
