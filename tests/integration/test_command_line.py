"""`tumble` alone, other names of commands, and what a shell completes."""

import argparse
import json
import os
import shutil
import subprocess
import sys

import pytest
from conftest import ROOT

from tumble.cli.commands import COMMANDS
from tumble.cli.main import SHELLS, _parser, main, parse

pytestmark = pytest.mark.python


def test_alone_it_prints_its_help(tumble):
    alone, asked = tumble(), tumble("--help")
    assert (alone.returncode, alone.stderr) == (0, "") and alone.stdout == asked.stdout
    assert "apply" in alone.stdout and "COMMAND" in alone.stdout


def test_a_command_that_is_none_is_still_refused(refused):
    assert "invalid choice: 'solves'" in refused("solves")


MISSPELT = [
    (("slove", "run.csv"), "did you mean solve? (see tumble --help)"),
    (("plan", "bugdet"), "did you mean budget? (see tumble plan --help)"),
    (("solve", "run.csv", "--estimater=refined"), "did you mean --estimator? (see tumble solve --help)"),
    (("solve", "run.csv", "--estimator", "refind"), "did you mean refined? (see tumble solve --help)"),
    (("--hlep",), "did you mean --help? (see tumble --help)"),
]


@pytest.mark.parametrize(("words", "guess"), MISSPELT)
def test_a_misspelt_word_gets_a_guess(words, guess, capsys):
    assert main([*words]) == 2
    said = capsys.readouterr().err
    assert said.endswith(f"; {guess}\n") and said.count("\n") == 1


def test_what_resembles_nothing_gets_none(capsys):
    assert (main(["xyzzy"]), main(["solve", "run.csv", "--xyzzy"])) == (2, 2)
    assert "did you mean" not in capsys.readouterr().err


def leaves(parser, words=()):
    """Every command that runs, as its words."""
    [*subjects] = [action for action in parser._actions if isinstance(action, argparse._SubParsersAction)]
    if not subjects:
        yield " ".join(words)
    for name, one in (item for subject in subjects for item in subject.choices.items()):
        if name not in {alias for command in COMMANDS.values() for alias in command.aliases}:
            yield from leaves(one, (*words, name))


def test_every_command_has_an_example_in_its_help_which_parses(capsys):
    parser = _parser()
    examples = [example for command in COMMANDS.values() for example in command.examples]
    for name in leaves(parser):
        [example] = [one for one in examples if f"{one} ".startswith(f"tumble {name} ")]
        examples.remove(example)
        assert len(example) <= 70
        parser.parse_args(example.split()[1:])
        with pytest.raises(SystemExit):
            main([*name.split(), "--help"])
        assert capsys.readouterr().out.endswith(f"\nExample: {example}\n")
    assert examples == []
    for words, example in (([], "solve run.csv"), (["plan"], "plan budget"), (["campaign"], "campaign runs")):
        with pytest.raises(SystemExit):
            main([*words, "--help"])
        assert f"\nExample: tumble {example} " in capsys.readouterr().out


def test_help_and_usage_errors_need_no_package():
    """Nor does a result that is not there: a checkout answers them before it installs anything (tools/usage)."""
    program = (
        "import contextlib, io, json, sys\n"
        "sys.path.insert(0, sys.argv[1])\n"
        "from tumble.cli.main import parse\n"
        "told = contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO())\n"
        "with told[0], told[1]: codes = [parse(words) for words in json.loads(sys.argv[2])]\n"
        "print(codes)"
    )
    names = sorted({name[:end] for name in leaves(_parser()) for end in (name.find(" "), None) if end != -1})
    asked = [[*name.split(), word] for word in ("--help", "--no-such-option") for name in names]
    asked += [["report", "none.json"], ["export", "none.json", "--format", "c"], ["apply", "none.json", "data.csv"]]
    command = [sys.executable, "-I", "-S", "-c", program, str(ROOT / "host/python/src"), json.dumps(asked)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert json.loads(done.stdout) == [10] * len(names) + [2] * (len(names) + 3) and len(names) > 20


def test_a_result_that_is_not_there_is_told_once(capsys):
    for words in (["export", "none.json", "--format", "c"], ["export", "none.json", "--format", "dcc"],
                  ["report", "none.json"], ["apply", "none.json", "data.csv"]):  # fmt: skip
        for run in (parse, main):
            assert run(words) == 2
            assert capsys.readouterr().err == "tumble: none.json: no such file or folder\n"


def test_a_command_is_loaded_only_when_it_is_named():
    """Its name and what it is about stand where they cost nothing; and the help is the same."""
    program = (
        "import sys; from tumble.cli.main import main, _parser\n"
        "loaded = lambda: sorted(one for one in sys.modules if one.startswith('tumble.cli.commands.'))\n"
        "for words in (['--help'], ['solve', '--help']):\n"
        "    try: main(words)\n"
        "    except SystemExit: print(loaded())\n"
        "print(_parser(()).format_help() == _parser().format_help(), len(loaded()) > 12)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    lists = [line for line in done.stdout.splitlines() if line.startswith(("[]", "['", "True", "False"))]
    assert lists == ["[]", "['tumble.cli.commands.solve']", "True True"]


def test_a_run_folder_is_told_which_of_its_files_to_give(tmp_path, capsys):
    for name in ("run.csv", "result.json"):
        (tmp_path / name).write_text("")
    for words, name in ((("report",), "result.json"), (("export", "--format", "c"), "result.json"),
                        (("solve",), "run.csv"), (("compare", "other.json"), "result.json")):  # fmt: skip
        (tmp_path / "other.json").write_text("")
        command, *more = words
        files = [str(tmp_path)] if command != "compare" else [str(tmp_path), str(tmp_path / more.pop())]
        assert main([command, *files, *more]) == 2
        assert capsys.readouterr().err == f"tumble: {tmp_path}: a folder, not a file: give {tmp_path / name}\n"


def test_simulate_is_bench(tumble, refused):
    assert tumble("simulate", "--help").stdout == tumble("bench", "--help").stdout != ""
    assert refused("simulate", "--seed", "-1") == refused("bench", "--seed", "-1")


def test_completion_without_shtab():
    program = "import sys; sys.modules['shtab'] = None; from tumble.__main__ import run; sys.exit(run())"
    done = subprocess.run([sys.executable, "-c", program, "--print-completion", "bash"], capture_output=True, text=True)
    said = "tumble: --print-completion needs shtab: .venv/bin/pip install shtab\n"
    assert (done.returncode, done.stdout, done.stderr) == (77, "", said)


ASK = """
source "$1"; shift
COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1))
_shtab_tumble
printf '%s\\n' "${COMPREPLY[@]}"
"""


@pytest.fixture
def script(capsys):
    """What --print-completion prints for a shell."""
    pytest.importorskip("shtab")

    def printed(shell):
        with pytest.raises(SystemExit) as ended:
            main(["--print-completion", shell])
        assert ended.value.code == 0
        return capsys.readouterr().out

    return printed


@pytest.mark.toolchain
@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash")
def test_bash_completes_commands_options_choices_and_files(script, tmp_path):
    (tmp_path / "completion").write_text(script("bash"))
    (tmp_path / "measured.csv").write_text("")

    def completed(*words):
        command = ["bash", "-c", ASK, "ask", tmp_path / "completion", "tumble", *words]
        return subprocess.run(command, capture_output=True, text=True, check=True, cwd=tmp_path).stdout.split()

    assert "apply" in completed("ap") and "simulate" in completed("si")
    assert completed("solve", "--esti") == ["--estimator"]
    formats = {"c", "csv", "matlab", "ros", "imucal", "px4", "ardupilot", "dcc"}
    assert set(completed("export", "--format", "")) == formats
    assert completed("apply", "meas") == ["measured.csv"]


@pytest.mark.toolchain
@pytest.mark.parametrize("shell", SHELLS)
def test_every_shell_has_a_script(shell, script):
    text = script(shell)
    assert "tumble" in text and "uncertainty" in text
    if shutil.which(shell):
        subprocess.run([shell, "-n"], input=text, text=True, check=True)


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason="one processor")
@pytest.mark.parametrize(("given", "threads"), [({}, 1), ({"OPENBLAS_NUM_THREADS": "2"}, 2)])
def test_numpy_has_one_thread_unless_somebody_asks_for_more(given, threads):
    """As a process of its own; a script that imports the package keeps numpy as it was."""
    environment = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    count = "import tumble.__main__, os, numpy; print(len(os.listdir('/proc/self/task')))"
    count += "; print(open('/proc/self/maps').read())"
    done = subprocess.run([sys.executable, "-c", count], env={**environment, **given}, capture_output=True, text=True)
    assert done.stderr == ""
    if "openblas" not in done.stdout:
        pytest.skip("this numpy has another library for matrices")
    assert int(done.stdout.split()[0]) == threads
