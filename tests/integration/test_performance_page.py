"""docs/performance.md and what makes its tables: one command, which measures all and takes over what people set."""

import subprocess
import sys

import pytest
from conftest import ROOT

sys.path.insert(0, str(ROOT / "tests/benchmark"))

import all as every
import costs_page as page

TEXT = """# Page

<!-- tools/benchmark one --table -->
| | now | goal |
|---|---|---|
| a b | 1,000 | 9 |

On a machine.
<!-- end -->

Prose | x.
<!-- tools/benchmark two --table -->
<!-- end -->
"""
OLD = "| | now | goal |\n|---|---|---|\n| a b | 1,000 | 9 |\n\nOn a machine.\n"


def test_tables_are_found_by_what_prints_them():
    assert page.names(TEXT) == ["one", "two"]
    assert page.rows_of(page.table_of(TEXT, "one")) == {"a b": {"now": "1,000", "goal": "9"}}
    assert page.table_of(TEXT, "two") == []
    with pytest.raises(ValueError, match="three"):
        page.table_of(TEXT, "three")


def test_a_table_takes_the_place_of_the_old_one_and_nothing_else_changes():
    new = page.markdown(["now", "goal"], {"a b": {"now": "2"}})
    assert new == "|  | now | goal |\n|---|---|---|\n| a b | 2 |  |"
    assert page.rows_of(new.splitlines()) == {"a b": {"now": "2", "goal": ""}}
    changed = page.with_part(page.with_part(TEXT, "one", new), "two", "Words.")
    assert changed == TEXT.replace(OLD, new + "\n").replace("two --table -->\n", "two --table -->\nWords.\n")


@pytest.mark.parametrize(("now", "said", "said_before", "expected"), [
    (1020, "1,000", "7", "7"),
    (1021, "1,000", "7", "1,000"),
    (979, "1,000", "", "1,000"),
    (979, "", "", ""),
    (0, "0", "", ""),
])
def test_before_is_the_last_figure_that_differs(now, said, said_before, expected):
    assert page.before(now, said, said_before) == expected


@pytest.mark.parametrize(("exits", "expected"), [((0, 0), 0), ((0, 77), 77), ((77, 0), 77), ((1, 77), 1), ((2, 0), 1)])
def test_what_is_left_out_stays_as_it_was(tmp_path, monkeypatch, capsys, exits, expected):
    path = tmp_path / "performance.md"
    path.write_text(TEXT)
    monkeypatch.setattr(page, "PAGE", path)
    monkeypatch.setattr(every, "HERE", tmp_path)
    for name, code in zip(("one", "two"), exits):
        program = f"import sys\nassert sys.argv[1:] == ['--table']\nprint('| new |')\nsys.exit({code})\n"
        (tmp_path / f"{name}.py").write_text(program)
    assert every.main(["--write"]) == expected
    shown = capsys.readouterr().out
    for name, code in zip(("one", "two"), exits):
        assert (f"<!-- tools/benchmark {name} --table -->\n| new |\n<!-- end -->\n" in shown) == (code == 0)
        assert page.table_of(path.read_text(), name) == (["| new |"] if code == 0 else page.table_of(TEXT, name))


def test_each_program_that_the_page_names_prints_a_table():
    """The option is there; the figures are for the benchmarks' own tests."""
    named = page.names(page.PAGE.read_text(encoding="utf-8"))
    assert {"cortex_m4", "latency", "solve", "simulation"} <= set(named) and len(named) == len(set(named))
    for name in named:
        assert page.table_of(page.PAGE.read_text(encoding="utf-8"), name)
        assert '"--table"' in (ROOT / f"tests/benchmark/{name}.py").read_text(encoding="utf-8")


def test_a_name_that_is_none_is_refused():
    refused = subprocess.run([ROOT / "tools/benchmark", "nothing"], capture_output=True, text=True, check=False)
    assert refused.returncode == 2
    named = "all campaign cortex_m4 entered hand_laid history latency prior sample_way scaling simulation "
    assert f"NAME is one of: {named}" in refused.stderr
