"""The C in docs/files.md: it compiles with our warnings, and does with real files what the page says."""

import json
import os
import re
import shutil
import subprocess

import numpy as np
import pytest
from conftest import EXAMPLES, ROOT

PAGE = re.search(r"```c\n(.*?)```", (ROOT / "docs" / "files.md").read_text(encoding="utf-8"), re.DOTALL)[1]
MAIN = """
#include <stdio.h>
int main(void)
{
    static _Alignas(8) unsigned char memory[65536];
    static tumble_means_t means;
    FILE *gains = fopen("gains.bin", "rb");
    const size_t size = gains ? fread(memory, 1, sizeof memory, gains) : 0;
    for (int p = 0; p < 18; p++) {
        means.measured[p] = scanf("%lf %lf %lf", &means.u_v[p][0], &means.u_v[p][1], &means.u_v[p][2]) == 3;
    }
    tumble_coefficients_t found;
    if (calibrate(memory, size, &means, &found) != TUMBLE_OK) return 1;
    for (int i = 0; i < 9; i++) printf("%.17g\\n", found.k_v_per_g[i / 3][i % 3]);
    for (int i = 0; i < 3; i++) printf("%.17g\\n", found.u0_v[i]);
    double a_g[3];
    if (to_g(means.u_v[0], a_g) != TUMBLE_OK) return 2;
    printf("%.17g\\n%.17g\\n%.17g\\n", a_g[0], a_g[1], a_g[2]);
    memory[300] ^= 1;
    return calibrate(memory, size, &means, &found) == TUMBLE_E_CRC ? 0 : 3;
}
"""


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_the_ten_lines_of_c(tumble, tmp_path):
    """Coefficients of the gain record near those of `solve --estimator optimal`; outputs turned into 1 g."""
    stand = ("--stand", EXAMPLES / "paper_stand.toml")
    solve = ("solve", EXAMPLES / "paper_stand.csv", *stand, "--estimator", "optimal")
    assert tumble(*solve, "--out", tmp_path / "result.json").returncode == 0
    assert tumble("plan", "optimize", *stand, "--out", tmp_path / "gains.bin").returncode == 0
    export = ("export", tmp_path / "result.json", "--format", "c", "--out", tmp_path / "coefficients.h")
    assert tumble(*export).returncode == 0
    (tmp_path / "main.c").write_text(PAGE + MAIN)
    flags = "-std=c11 -ffp-contract=off -Wall -Wextra -Wconversion -Wshadow -Werror".split()
    sources = sorted((ROOT / "firmware" / "core").glob("*.c"))
    environment = {name: value for name, value in os.environ.items() if name != "LD_PRELOAD"}
    command = [
        "cc",
        *flags,
        f"-I{ROOT / 'firmware'}",
        f"-I{ROOT / 'firmware/include'}",
        "-I.",
        "main.c",
        *sources,
        "-lm",
        "-o",
        "main",
    ]
    subprocess.run(command, cwd=tmp_path, check=True, env=environment)
    result = json.loads((tmp_path / "result.json").read_text())
    means = [mean["mean"] for mean in result["means"]]
    text = "\n".join(" ".join(map(repr, mean)) for mean in means)
    done = subprocess.run([tmp_path / "main"], input=text, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0
    printed = np.array([float(line) for line in done.stdout.split()])
    u = np.array([*np.ravel(result["u_K"]), *result["u_U0"]])
    assert np.abs((printed[:12] - [*np.ravel(result["K"]), *result["U0"]]) / u).max() < 0.5  # weights of another K
    assert printed[12:] == pytest.approx(np.linalg.solve(result["K"], np.subtract(means[0], result["U0"])), rel=1e-12)
