"""tools/trial gives every shell command that README and pages print, or says why not; it notices one that is new, and
reads the line for an administrator out of what set-up says."""
import importlib.util
import re
from importlib.machinery import SourceFileLoader

import pytest
from conftest import ROOT
from test_setup import NEEDED, WITHOUT_PANGO

loader = SourceFileLoader("trial", str(ROOT / "tools/trial"))
trial = importlib.util.module_from_spec(importlib.util.spec_from_loader("trial", loader))
loader.exec_module(trial)

PAGES = [path.read_text(encoding="utf-8") for path in (ROOT / "README.md", *(ROOT / "docs").glob("*.md"))]
STEPS = [step for _, given in trial.systems("root") for block in given for step in block]


def test_every_command_is_given_or_left_out():
    printed = [line for page in PAGES for block in re.findall(r"```console\n(.*?)```", page, re.DOTALL)
               for line in re.findall(r"^\$ (.*)$", re.sub(r" *\\\n +", " ", block), re.MULTILINE)]
    given = "\n".join(step.command for step in STEPS).splitlines()
    assert len(printed) > 50 and [line for line in printed if line not in given] == []
    readme = [step for block in trial.blocks(PAGES[0]) for step in block]
    assert len(readme) == 15 and not any(step.why_not for step in readme)
    assert all(any(word in page for page in PAGES) for word in trial.LEFT_OUT)


def test_what_a_page_says_of_a_command_is_followed():
    words = ("| ./main", "import examples/hand_held_session.csv", "-S tumble/firmware", "pkg-config", "--interactive")
    found = ([step for step in STEPS if word in step.command] for word in words)
    (main,), (*_, bare), (cmake,), (embed,), (asked,) = found
    file, text = main.saved
    assert file == "main.c" and text.startswith("#include <stdio.h>") and text.endswith("}\n")
    assert bare.expected == 2 and {step.expected for step in STEPS if step != bare} == {0}
    assert cmake.folder == embed.folder == "" and embed.command.startswith("export PKG_CONFIG_PATH=")
    assert main.folder == "tumble" and asked.why_not == "somebody who answers"


def test_who_has_no_rights_gives_no_sudo():
    assert [name for name, _ in trial.systems("guest")] == ["checkout"]
    assert [name for name, _ in trial.systems("sudoer")] == ["checkout", "pip"]


@pytest.mark.parametrize("said", [
    f"tumble: set-up: cannot install gcc: sudo refused. {NEEDED} (log: /a/b)\n", WITHOUT_PANGO])
def test_the_line_for_an_administrator_is_found(said):
    line = trial.ADMINISTRATOR.search(f"$ ./tools/tumble\n{said}")[1]
    assert line.startswith("apt-get install --no-install-recommends ") and line.endswith(" fonts-dejavu-core")


def test_without_debootstrap_or_root_it_is_skipped(monkeypatch, capsys):
    monkeypatch.setenv("PATH", "/nowhere")
    assert trial.main([]) == 77 and capsys.readouterr().out.startswith("no trial on a bare Debian: ")
