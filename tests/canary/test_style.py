"""tools/style.py rejects another layout of C, an unused import and a wrong type, and accepts what has none of them."""

import shutil

import pytest
from conftest import ROOT, run
from stages import PYTHON

CLEAN = {
    "firmware/core/half.c": "double half(double x)\n{\n    return x / 2.0;\n}\n",
    "firmware/navcomp/objects.c": "int generated(void) {return 0;}\n",
    "tools/half.py": "import os\n\nprint(os.sep)\n",
    "tests/unit/half.h": "enum { HALF = 2 };\n",
    "tests/integration/test_half.py": "def test_half():\n    assert 1 / 2 == 0.5\n",
    "host/python/src/tumble/__init__.py": "",
    "host/python/src/tumble/half.py": "def half(x: float) -> float:\n    return x / 2\n",
}
LAYOUT = "[-Wclang-format-violations]"
DEFECTS = {
    "a brace beside its function": ("firmware/core/half.c", "double f(double x) {\n    return x;\n}\n", LAYOUT),
    "two blanks": ("tests/unit/half.h", "enum { HALF =  2 };\n", LAYOUT),
    "a table of Python's": ("host/python/src/tumble/half.py", 'half = {"half":0.5}\n', "half.py"),
    "an unused import": ("tools/half.py", "import os\n", "F401"),
    "imports out of order": ("tests/integration/test_half.py", "import sys\nimport os\n\nprint(os, sys)\n", "I001"),
    "a line too long in a program without a suffix": (
        "tools/trial", f"#!/usr/bin/env python3\nprint({'1 + ' * 30}1)\n", "E501"),
    "a line too long": ("tools/half.py", f"print({'1 + ' * 30}1)\n", "E501"),
    "a wrong type": ("host/python/src/tumble/half.py", 'half: float = "0.5"\n', "[assignment]"),
    "no types": ("host/python/src/tumble/half.py", "def half(x):\n    return x / 2\n", "[no-untyped-def]"),
}
CONFIGURATION = (".clang-format", ".clang-format-ignore", "ruff.toml", "host/python/pyproject.toml", "tools/style.py")


def plant(root, files):
    for name in CONFIGURATION:
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, root / name)
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    result = run(PYTHON, root / "tools/style.py")
    if result.returncode == 77:
        pytest.skip(result.stdout.splitlines()[-1])
    return result


def test_accepts(tmp_path):
    result = plant(tmp_path, CLEAN)
    assert result.returncode == 0, result.stdout


@pytest.mark.parametrize("defect", DEFECTS)
def test_rejects(defect, tmp_path):
    file, text, told = DEFECTS[defect]
    result = plant(tmp_path, CLEAN | {file: text})
    assert result.returncode == 1, result.stdout
    lines = [line for line in result.stdout.splitlines() if told in line]
    assert lines and all(file in line for line in lines), result.stdout


def test_a_missing_tool_is_a_skip_and_not_a_pass():
    code = "import shutil, sys; sys.path.insert(0, 'tools'); shutil.which = lambda *_, **__: None; import style; "
    result = run(PYTHON, "-B", "-c", code + "sys.exit(style.main([]))")
    told = "no tool for layout, lint, types; tools/requirements-style.txt names them\n"
    assert (result.returncode, result.stdout) == (77, told)
