"""The documentation site: every page can be found, what is generated is complete, nothing comes from the network, and
the notebook says what it said when it was stored."""

import json
import os
import re
import shutil
import subprocess
import sys

import core_functions
import pytest
from conftest import ROOT

import tumble as package

sys.path.insert(0, str(ROOT / "tools/documentation"))

import navigation
import notebook

import build

pytestmark = pytest.mark.python

HEADERS = sorted((ROOT / "firmware/include/tumble").glob("*.h"))
NOTEBOOK = ROOT / "docs/notebook.ipynb"


BUILDS = [
    pytest.mark.toolchain,
    pytest.mark.slow,
    pytest.mark.skipif(bool(build.missing()), reason=f"not installed: {', '.join(build.missing())}"),
]


def test_every_page_is_in_the_navigation_once():
    site = navigation.read_site(ROOT)
    names = [navigation.name_of(entry) for part in site.parts for entry in part["pages"]]
    assert navigation.unlisted(ROOT, site) == []
    assert len(names) == len(set(names)) and site.home not in names
    assert {name for name in names if name not in site.sources} == {
        "reference/command-line", "reference/schemas", "reference/python", "reference/c"}  # fmt: skip


def test_links_to_folders_lead_to_pages():
    site = navigation.read_site(ROOT)
    for path, name in site.instead.items():
        assert (ROOT / path).exists() and (name in site.sources or name.startswith("reference/")), path


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The site, built anew: a function from the name of a page to its text."""
    out = tmp_path_factory.mktemp("site") / "html"
    done = subprocess.run([sys.executable, "tools/documentation/build.py", out], cwd=ROOT, capture_output=True,
                          text=True, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)})  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert re.fullmatch(r"site: \d+ pages in .*\n", done.stdout)
    read = lambda name: (out / name).read_text(encoding="utf-8")  # noqa: E731
    read.folder = out
    return read


def found_by_search(site, query):
    """What the page of search lists in a browser, best first: what it leads to, and what is said of it."""
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("chromium is not installed")
    page = subprocess.run(
        [chromium, "--headless=new", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=20000", "--dump-dom",
         f"file://{site.folder}/search.html?q={query}"],
        capture_output=True, text=True, check=True, timeout=120,
    ).stdout  # fmt: skip
    results = page.partition('class="search"')[2].partition("</ul>")[0].split("<li")[1:]
    return [(re.search(r'href="([^"?#]*)', one)[1], re.sub(r"<.*?>", "", f"<li{one}")) for one in results]


class TestBuilt:
    pytestmark = BUILDS

    def test_the_home_page_leads_to_every_page(self, site):
        text = site("index.html")
        for entry in (entry for part in navigation.read_site(ROOT).parts for entry in part["pages"]):
            assert f'href="{navigation.name_of(entry)}.html"' in text, entry

    def test_nothing_comes_from_the_network(self, site):
        """As in built.py, by another look: whatever is not a link that a reader follows."""
        for name in ("index.html", "method.html", "reference/c-core.html", "search.html"):
            for tag in re.findall(r"<(?!a )\w[^>]*://[^>]*>", site(name)):
                assert tag.startswith(("<math xmlns=", "<svg ")), f"{name}: {tag}"

    def test_formulas_are_mathml(self, site):
        text = site("method.html")
        assert '"STIX Two Math"' in site("_static/site.css")
        assert "<msub><mi>U</mi><mn>0</mn></msub>" in text and not re.search(r"\\(frac|alpha|sum|left)", text)

    def test_code_can_be_copied(self, site):
        assert "copybutton.js" in site("first-calibration.html")

    def test_search_finds_without_a_server(self, site):
        """Its index is a script that the page loads: browsers let files load scripts, but no data."""
        assert 'src="searchindex.js"' in site("search.html")
        assert "tumble_estimate_refined" in site("searchindex.js")

    @pytest.mark.parametrize(
        ("query", "page"),
        [
            ("refined", "method.html"),
            ("coverage+factor", "method.html"),
            ("import", "first-calibration.html"),
            ("limit", "schedules.html"),
        ],
    )
    def test_search_lists_pages_before_parameters(self, query, page, site):
        found = found_by_search(site, query)
        of_pages = [place for place, (_, said) in enumerate(found) if "(C " not in said]
        of_names = [place for place, (_, said) in enumerate(found) if "(C " in said]
        assert page in [target for target, _ in found[: len(of_pages)]]
        assert max(of_pages) < min(of_names, default=len(found))

    def test_search_lists_a_function_first(self, site):
        _, first = found_by_search(site, "tumble_estimate_refined")[0]
        assert "tumble_estimate_refined (C function, in tumble/core.h)" in first

    @pytest.mark.parametrize("header", HEADERS, ids=lambda path: path.stem)
    def test_all_that_a_header_declares_has_an_anchor(self, header, site):
        text = re.sub(r"/\*.*?\*/", "", header.read_text(), flags=re.DOTALL)
        called = re.findall(r"^\w[\w *]*?\b(tumble_\w+)\(", text, re.MULTILINE)
        types = re.findall(r"^} (tumble_\w+);", text, re.MULTILINE)
        constants = re.findall(r"^#define (TUMBLE_(?!\w*_H\b)\w+)", text, re.MULTILINE)
        constants = [name for name in constants if f"#undef {name}\n" not in text]
        page = site(f"reference/c-{header.stem}.html")
        assert called or types or constants
        assert [name for name in [*called, *types, *constants] if f'id="c.{name}"' not in page] == []

    def test_a_refusal_leads_to_its_sentence(self, site):
        text = site("reference/c-status.html")
        for name, sentence in core_functions.statuses():
            assert f'id="c.{name}"' in text and sentence[1:] in text.replace("&#x27;", "'"), name
        assert 'href="c-status.html#c.TUMBLE_E_RANK"' in site("reference/c-core.html")

    def test_all_public_names_of_the_package_are_there(self, site):
        text = site("reference/python.html")
        names = [name for name in package.__all__ if name != "__version__"]
        assert [name for name in names if f'id="tumble.{name}"' not in text] == []
        assert 'id="tumble.Result.apply"' in text
        assert "<strong>levelled</strong> (<em>str</em><em>, </em><em>optional</em>)" in text

    def test_the_help_of_every_command_is_there(self, site, tumble):
        text = site("reference/command-line.html")
        commands = re.findall(r"^    (\w+)(?: \([\w, ]+\))? ", tumble("--help").stdout, re.MULTILINE)
        assert {"solve", "import", "apply", "plan", "fixture"} <= set(commands)
        for command in [*commands, "plan require", "fixture check"]:
            assert f"usage: tumble {command} " in text, command

    def test_a_folder_with_something_else_stays(self, tmp_path):
        (tmp_path / "mine.txt").write_text("kept")
        done = subprocess.run([sys.executable, "tools/documentation/build.py", tmp_path], cwd=ROOT,
                              capture_output=True, text=True)  # fmt: skip
        assert done.returncode == 2 and done.stderr == f"site: {tmp_path} holds something else than a site\n"
        assert (tmp_path / "mine.txt").read_text() == "kept"

    def test_the_notebook_says_the_same_again(self, tmp_path, monkeypatch):
        monkeypatch.setenv("PYTHONPATH", os.pathsep.join(sys.path))
        notebook.execute(NOTEBOOK, tmp_path / "again.ipynb")
        assert notebook.told(tmp_path / "again.ipynb") == notebook.told(NOTEBOOK)
        assert sum(map(len, notebook.told(NOTEBOOK))) >= 8


def test_the_notebook_is_stored_as_it_ran():
    """Every cell of code has been executed, in order."""
    cells = [cell for cell in json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]
    assert [cell["execution_count"] for cell in cells] == list(range(1, len(cells) + 1))


@pytest.mark.parametrize("told", ["a b", "--out"])
def test_it_says_how_it_is_called(told):
    done = subprocess.run([sys.executable, "tools/documentation/build.py", *told.split()], cwd=ROOT,
                          capture_output=True, text=True)  # fmt: skip
    assert (done.returncode, done.stdout, done.stderr) == (2, "", "usage: tools/site [OUT | --notebooks]\n")
