"""tools/site rejects a page that nobody finds, links and formulas that do not work, and what would come from the
network."""

import os
import shutil
import sys

import pytest
from conftest import ROOT, run

sys.path.insert(0, str(ROOT / "tools/documentation"))

import built
import c_headers

import build

CLEAN = {
    "index.html": '<h1 id="top">Home</h1><a href="other.html#part">there</a><a href="#top">up</a>'
                  '<a href="https://example.org/">elsewhere</a><img src="a.svg"><script src="search.js"></script>',
    "other.html": '<h2 id="part">Part</h2><a href="a.svg">drawing</a><a href="other.html?highlight=x#part">again</a>',
    "a.svg": '<svg xmlns="http://www.w3.org/2000/svg"><rect fill="url(#shade)"/></svg>',
    "site.css": "body { background: url(a.svg); }",
    "search.js": "",
}  # fmt: skip
DEFECTS = {
    "a page that is not there": ("index.html", '<a href="gone.html">', "index.html: leads nowhere: gone.html"),
    "an anchor that is not there": ("index.html", '<a href="other.html#gone">',
                                    "index.html: leads nowhere: other.html#gone"),
    "an anchor of its own": ("other.html", '<a href="#gone">', "other.html: leads nowhere: #gone"),
    "a script": ("index.html", '<script src="https://cdn.example/m.js"></script>',
                 "index.html: would fetch https://cdn.example/m.js"),
    "any scheme": ("index.html", '<img src="//cdn.example/a.png">', "index.html: would fetch //cdn.example/a.png"),
    "a style sheet": ("index.html", '<link rel="stylesheet" href="http://cdn.example/s.css">',
                      "index.html: would fetch http://cdn.example/s.css"),
    "a font": ("site.css", "@font-face { src: url('https://fonts.example/f.woff2'); }",
               "site.css: would fetch https://fonts.example/f.woff2"),
    "an import": ("site.css", '@import "https://fonts.example/css";',
                  "site.css: would fetch https://fonts.example/css"),
    "in a style": ("index.html", '<p style="background: url(https://cdn.example/p.png)">',
                   "index.html: would fetch https://cdn.example/p.png"),
}  # fmt: skip


def plant(folder, files):
    for name, text in files.items():
        (folder / name).write_text(text)
    return built.faults(folder)


def test_accepts_a_clean_site(tmp_path):
    assert plant(tmp_path, CLEAN) == []


@pytest.mark.parametrize("name", DEFECTS)
def test_rejects(tmp_path, name):
    file, text, message = DEFECTS[name]
    assert message in plant(tmp_path, {**CLEAN, file: CLEAN[file] + text})


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """Exit code and lines of a build of a tree like this one with all the defects below."""
    if missing := build.missing():
        pytest.skip(f"not installed: {', '.join(missing)}")
    root = tmp_path_factory.mktemp("tree")
    for path in ROOT.iterdir():
        if path.name not in ("docs", "tools", "build", ".git", ".venv"):
            (root / path.name).symlink_to(path)
    shutil.copytree(ROOT / "docs", root / "docs")
    shutil.copytree(ROOT / "tools", root / "tools")
    with open(root / "docs/first-calibration.md", "a", encoding="utf-8") as page:
        page.write("\n".join(["", *(text for text, *_ in PLANTED.values()), ""]))
    (root / "docs/orphan.md").write_text("# Nobody finds this\n")
    searched = os.pathsep.join([f"{ROOT}/host/python/src", f"{ROOT}/build/host/python", *sys.path])
    done = run(sys.executable, root / "tools/documentation/build.py", PYTHONPATH=searched)
    return done.returncode, done.stdout


PAGE, BUILT = "docs/first-calibration.md", "first-calibration.html"
PLANTED = {  # what is added to a page; what the complaints say of it; where they say it is, the builder's and ours
    "a page": ("[gone](no-such-page.md)\n", "no-such-page.md", [PAGE, BUILT]),
    "a heading": ("[gone](files.md#no-such-heading)\n", "no-such-heading", [PAGE, BUILT]),
    "a picture": ("![gone](no-such-picture.svg)\n", "no-such-picture.svg", [PAGE]),
    "a formula": ("Then $\\nosuchcommand x$ is one.\n", "nosuchcommand", [PAGE]),
    "a picture from elsewhere": ('<img src="https://example.org/a.png">\n', "fetch https://example.org/a.png", [BUILT]),
}


@pytest.mark.parametrize("name", PLANTED)
def test_the_build_rejects(told, name):
    status, text = told
    _, said, places = PLANTED[name]
    assert status == 1
    assert [line.split(":")[0] for line in text.splitlines() if said in line] == places, text


def test_the_build_rejects_a_page_outside_of_the_navigation(told):
    assert told[0] == 1 and "docs/orphan.md: not in docs/site.toml, so no reader finds it" in told[1].splitlines()


def test_a_header_is_shown_whole_or_not_at_all():
    guard = "#ifndef TUMBLE_X_H\n#define TUMBLE_X_H\n"
    [entry] = c_headers.read_header(f"{guard}/* Of x. */\nint tumble_x(int a);\n#endif\n")
    assert [item.name for item in entry.declared] == ["tumble_x"]
    with pytest.raises(ValueError, match=r"no declaration that c_headers\.py knows: union tumble_x"):
        c_headers.read_header(f"{guard}union tumble_x {{\n    int a;\n}};\n#endif\n")
