"""tools/mutation on a program of two functions: what it draws, what is killed, what survives, and the ratchet."""

import json
import subprocess
import sys

import pytest
from conftest import ROOT

pytestmark = [pytest.mark.python, pytest.mark.slow]
FILES = {
    "firmware/core/numbers.c": """#define LEAST 1 + 1
/* Not code: a < b, 3 */
int sum(int a, int b);
int largest(int a, int b);
int sum(int a, int b)
{
    return a + b;
}

int largest(int a, int b)
{
    return (a > b) ? a : b;
}
""",
    "tests/unit/test_numbers.c": """int sum(int a, int b);
int largest(int a, int b);
int main(void)
{
    return sum(2, 3) != 5 || largest(2, 3) != 3 || largest(3, 2) != 3;
}
""",
    "tools/goldens": "",
    "CMakeLists.txt": """cmake_minimum_required(VERSION 3.22)
project(numbers LANGUAGES C)
enable_testing()
add_executable(test_numbers firmware/core/numbers.c tests/unit/test_numbers.c)
add_test(NAME test_numbers COMMAND test_numbers)
""",
    "CMakePresets.json": json.dumps({
        "version": 3,
        "configurePresets": [{"name": "host", "generator": "Ninja", "binaryDir": "${sourceDir}/build/host"}],
        "buildPresets": [{"name": "host", "configurePreset": "host"}],
    }),
}
EQUIVALENT = {"file": "firmware/core/numbers.c", "line": "return (a > b) ? a : b;", "mutation": "> to >="}


@pytest.fixture
def mutation(tmp_path):
    """Run it on that program, as it stands there: exit code, and the last line."""
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    subprocess.run(["git", "init", "-q"], cwd=tmp_path, check=True)
    subprocess.run(["git", "add", "."], cwd=tmp_path, check=True)

    def run(*options):
        command = [sys.executable, ROOT / "tools/mutation", "--root", tmp_path, "--mutants", "100", "--jobs", "1"]
        done = subprocess.run([*command, *options], capture_output=True, text=True, timeout=300)
        return done.returncode, done.stdout.splitlines()

    return run


def test_what_is_killed_and_what_survives(mutation, tmp_path):
    code, lines = mutation("--write")
    assert code == 0, lines
    assert lines[-1].startswith("mutation: 3 of 4 killed, 75.0 %, 0 of them by goldens alone; 0 do not compile")
    assert lines[-2] == "firmware/core/numbers.c:12: comparison, > to >=: return (a > b) ? a : b;"
    recorded = json.loads((tmp_path / "tools/mutation.json").read_text())
    assert recorded == {"mutants": 100, "seed": 1, "killed": 3, "judged": 4, "survivors": [EQUIVALENT]}
    assert (tmp_path / "firmware/core/numbers.c").read_text() == FILES["firmware/core/numbers.c"]

    test = tmp_path / "tests/unit/test_numbers.c"
    test.write_text(FILES["tests/unit/test_numbers.c"].replace("sum(2, 3) != 5 || ", ""))
    code, lines = mutation("--check")
    assert code == 1 and "mutation: 1 of 4 killed" in "".join(lines), lines
    assert "mutation: the score was 3 of 4; survivors that are new:" in lines
    assert len([line for line in lines if "'return a + b;'" in line]) == 2, lines

    test.write_text(FILES["tests/unit/test_numbers.c"])
    assert mutation("--check")[0] == 0


def test_tests_that_fail_without_a_mutant(mutation, tmp_path):
    (tmp_path / "tests/unit/test_numbers.c").write_text("int main(void)\n{\n    return 1;\n}\n")
    code, lines = mutation()
    assert (code, lines) == (1, [])
