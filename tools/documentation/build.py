"""Build the documentation site: gather its pages, let Sphinx build them with every warning an error, and check what
came out.

    tools/site [OUT]            default: build/site/html; exit 1 when something is wrong, 2 for OUT that is in use, 77
                                without Sphinx
    tools/site --notebooks      execute the notebooks of docs/ and store what they say; then read what has changed
"""

import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import built
import notebook
import pages

ROOT = Path(__file__).resolve().parents[2]
DEFAULT = ROOT / "build/site/html"
NEEDED = ("sphinx", "myst_parser", "furo", "sphinx_copybutton", "latex2mathml", "nbclient", "nbformat", "ipykernel",
          "matplotlib")  # fmt: skip
NOT_THERE = 77


def main(arguments):
    if arguments == ["--help"]:
        print(__doc__.strip())
        return 0
    if len(arguments) > 1 or (arguments != ["--notebooks"] and any(word.startswith("-") for word in arguments)):
        print("usage: tools/site [OUT | --notebooks]", file=sys.stderr)
        return 2
    if missing():
        print(f"site: not installed: {', '.join(missing())} (pip install -r tools/requirements-site.txt)")
        return NOT_THERE
    if arguments == ["--notebooks"]:
        for file in sorted((ROOT / "docs").rglob("*.ipynb")):
            notebook.execute(file, file)
        return 0
    out = Path(arguments[0]).absolute() if arguments else DEFAULT
    if arguments and is_in_use(out):
        print(f"site: {out} holds something else than a site", file=sys.stderr)
        return 2
    shutil.rmtree(out, ignore_errors=True)
    return build(out)


def missing():
    """Names of packages that are needed and not installed."""
    return [name for name in NEEDED if importlib.util.find_spec(name) is None]


def is_in_use(folder):
    """Does it hold what nobody may remove? A site of before may be replaced."""
    return folder.exists() and (not folder.is_dir() or (any(folder.iterdir()) and not (folder / ".buildinfo").exists()))


def build(out):
    """Build and check. Returns the exit code, and tells all that is wrong."""
    with tempfile.TemporaryDirectory(prefix="site-") as work:
        source = Path(work).resolve() / "pages"
        wrong = pages.gather(ROOT, source)
        wrong += warnings_of(source, out)
    wrong += built.faults(out) if out.exists() else []
    for line in wrong:
        print(line)
    count = len(list(out.rglob("*.html")))
    print(f"site: {len(wrong)} faults" if wrong else f"site: {count} pages in {os.path.relpath(out)}")
    return 1 if wrong else 0


def warnings_of(source, out):
    """What Sphinx complains of, a line each, with the names that the pages have in the repository."""
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", "-q", "-E", "-W", "--keep-going", "-b", "html", "-c", ROOT / "docs",
         "-d", source.parent / "doctrees", source, out],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
        env={**os.environ, "NO_COLOR": "1"},
    )  # fmt: skip
    told = done.stdout.replace(f"{source}/", "docs/").splitlines()
    return told or ([f"Sphinx ended with {done.returncode}"] if done.returncode else [])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
