"""What a user of the firmware includes: every header compiles alone, as C11 and as C++17,
and the example in it compiles."""

import re
import shutil
import subprocess

import pytest
from c_compiler import INCLUDES
from conftest import ROOT

DOORS = sorted(path.name for path in (ROOT / "firmware/include/tumble").glob("*.h"))
STRICT = ["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only"]
DIALECTS = {"c11": ["cc", "-std=c11", "-Wstrict-prototypes", "-x", "c"], "c++17": ["c++", "-std=c++17", "-x", "c++"]}


def includes_of(name):
    """A door compiles with the doors alone; but an object that holds those of other rooms needs their headers, too."""
    return INCLUDES if name in ("navcomp.h", "stand.h") else INCLUDES[1:]


def compile_text(text, dialect, includes, *flags):
    """The compiler's complaints about a program; none: it compiles."""
    command = [*DIALECTS[dialect], *flags]
    if shutil.which(command[0]) is None:
        pytest.skip(f"no {command[0]}")
    done = subprocess.run([*command, *STRICT, *includes, "-"], input=text, cwd=ROOT, text=True, capture_output=True)
    assert (done.returncode == 0) == (done.stderr == "")
    return done.stderr


def example_of(name):
    """The statements, or the whole file, that the header's own comment shows, or None."""
    text = (ROOT / "firmware/include/tumble" / name).read_text()
    found = re.search(r"The shortest program.*?:\n \*\n((?: \*(?:     .*)?\n)+)", text)
    return None if found is None else re.sub(r"^ \*(     )?", "", found[1], flags=re.MULTILINE)


@pytest.mark.parametrize("dialect", DIALECTS)
@pytest.mark.parametrize("name", DOORS)
def test_a_header_compiles_alone_and_twice(name, dialect):
    program = f'#include <tumble/{name}>\n#include "tumble/{name}"\nint main(void) {{ return 0; }}\n'
    assert compile_text(program, dialect, includes_of(name)) == ""


@pytest.mark.parametrize("name", [name for name in DOORS if example_of(name) is not None])
def test_the_example_compiles(name):
    example = example_of(name)
    is_file = example.startswith("#include")
    statements = "" if is_file else example
    program = f"#include <tumble/{name}>\n{example if is_file else ''}\nint main(void)\n{{\n{statements}return 0;\n}}\n"
    assert compile_text(program, "c11", includes_of(name)) == ""


@pytest.mark.parametrize("name, shown", [("core.h", "tumble_estimate_refined"), ("navcomp.h", "tumble_navcomp_step"),
                                         ("stand.h", "tumble_stand_kind_t table_kind = {")])
def test_a_door_shows_an_example(name, shown):
    assert shown in example_of(name)


@pytest.mark.parametrize("dialect", DIALECTS)
@pytest.mark.parametrize("flag", ["-ffast-math", "-Ofast", "-ffinite-math-only", "-fsingle-precision-constant"])
def test_other_arithmetic_is_refused(flag, dialect):
    """By a sentence that names the flag, or the one that it brings."""
    if flag == "-fsingle-precision-constant" and "clang" in subprocess.getoutput("cc --version"):
        pytest.skip("clang has no such flag")
    said = compile_text("#include <tumble/sets.h>\n", dialect, INCLUDES, flag)
    assert "results would differ" in said and flag.replace("-Ofast", "-ffast-math") in said
    assert compile_text("#include <tumble/sets.h>\n", dialect, INCLUDES, "-O3", "-fno-math-errno") == ""


@pytest.mark.parametrize("dialect", DIALECTS)
def test_what_does_not_compile_is_noticed(dialect):
    """Canary."""
    assert "error" in compile_text("#include <tumble/core.h>\ntumble_means_t *f(tumble_none_t *);\n", dialect, INCLUDES)
