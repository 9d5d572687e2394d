"""`tumble` alone, other names of commands, and what a shell completes."""

import shutil
import subprocess
import sys

import pytest

from tumble.cli.completion import SHELLS
from tumble.cli.main import main

pytestmark = pytest.mark.python


def test_alone_it_prints_its_help(tumble):
    alone, asked = tumble(), tumble("--help")
    assert (alone.returncode, alone.stderr) == (0, "") and alone.stdout == asked.stdout
    assert "apply" in alone.stdout and "COMMAND" in alone.stdout


def test_a_command_that_is_none_is_still_refused(refused):
    assert "invalid choice: 'solves'" in refused("solves")


def test_simulate_is_bench(tumble, refused):
    assert tumble("simulate", "--help").stdout == tumble("bench", "--help").stdout != ""
    assert refused("simulate", "--seed", "-1") == refused("bench", "--seed", "-1")


def test_completion_without_shtab():
    program = "import sys; sys.modules['shtab'] = None; from tumble.__main__ import run; sys.exit(run())"
    done = subprocess.run([sys.executable, "-c", program, "--print-completion", "bash"], capture_output=True, text=True)
    said = "tumble: --print-completion needs shtab: pip install 'tumble[completion]'\n"
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
    assert set(completed("export", "--format", "")) == {"c", "csv", "matlab", "ros", "imucal"}
    assert completed("apply", "meas") == ["measured.csv"]


@pytest.mark.toolchain
@pytest.mark.parametrize("shell", SHELLS)
def test_every_shell_has_a_script(shell, script):
    text = script(shell)
    assert "tumble" in text and "uncertainty" in text
    if shutil.which(shell):
        subprocess.run([shell, "-n"], input=text, text=True, check=True)
