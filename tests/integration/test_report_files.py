"""`tumble report` and its files: what is written where, templates, logos, numbers, and all that is refused."""

import base64
import copy
import json
import os
import random
import re
import subprocess
import sys

import pytest
from conftest import EXAMPLES, ROOT
from report_reader import Report, plain
from test_report import drawn, solve  # noqa: F401 # a fixture

import tumble as package
from tumble.api.result import Result
from tumble.cli.main import main
from tumble.errors import BadInput, UsageError
from tumble.report.make import context
from tumble.report.pages import css_string, number_of, own, require_number
from tumble.report.source import Source

pytest.importorskip("jinja2")
pytest.importorskip("matplotlib")
pytestmark = [pytest.mark.python, pytest.mark.toolchain]

PNG = base64.b64decode("iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAQAAAC1HAwCAAAAC0lEQVR42mNk+A8AAQUBAScY42YAAAAASUVORK5CYII=")
SVG = b'<?xml version="1.0"?>\n<!-- a logo -->\n<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"/>\n'


@pytest.fixture
def result(drawn, tmp_path):
    """A file of a result."""
    solve().save(tmp_path / "result.json")
    return tmp_path / "result.json"


def written(tmp_path, name, text):
    file = tmp_path / name
    file.write_bytes(text if isinstance(text, bytes) else text.encode("utf-8"))
    return file


# What is written where.


def test_the_command_the_function_and_standard_output_agree(result, tmp_path, capfdbinary):
    run = str(EXAMPLES / "paper_stand.csv")
    assert main(["report", str(result), "--out", str(tmp_path / "a.html"), "--run", run]) == 0
    assert main(["report", str(result), "--run", run]) == 0
    package.load(result).report(tmp_path / "b.HTM", run=run)
    said = capfdbinary.readouterr()
    assert said.err == b"" and said.out == (tmp_path / "a.html").read_bytes() == (tmp_path / "b.HTM").read_bytes()
    assert said.out.startswith(b"<!DOCTYPE html>")


def test_a_result_that_failed_is_reported_all_the_same(drawn, tmp_path):
    solve(limit_g=1e-6).save(tmp_path / "result.json")
    assert main(["report", str(tmp_path / "result.json"), "--out", str(tmp_path / "r.html")]) == 0
    assert "FAIL: the gravity check" in plain(Report((tmp_path / "r.html").read_text(encoding="utf-8")).text)


def test_the_layout_of_the_run_may_be_told(drawn, tmp_path):
    """And its unit is the result's, where it tells none."""
    run = written(tmp_path, "run.csv", (EXAMPLES / "paper_stand.csv").read_text().replace("ux", "AccX"))
    solved = package.solve(package.read(run, columns={"ux": "AccX"}, unit="V"), stand=EXAMPLES / "paper_stand.toml")
    solved.save(tmp_path / "result.json")
    arguments = [str(tmp_path / "result.json"), "--out", str(tmp_path / "r.html"), "--run", str(run)]
    assert main(["report", *arguments, "--columns", "ux=AccX"]) == 0
    assert drawn[-1][1].unit == "V" and len(drawn[-1][1]) == 900


@pytest.mark.parametrize("option", ["--columns=ux=AccX", "--delimiter=;", "--decimal=,", "--unit=V"])
def test_the_layout_of_no_run_is_refused(option, refused, result, tmp_path):
    line = refused("report", result, option, "--out", tmp_path / "r.html")
    name = option.partition("=")[0]
    assert line == f"tumble: {name} says how the run file is laid out: it needs --run RUN.csv\n"


@pytest.mark.parametrize("name", ["report.doc", "report", "report.html.gz", ".pdf"])
def test_another_ending_is_refused(name, refused, result, tmp_path):
    line = refused("report", result, "--out", tmp_path / name)
    assert line == f"tumble: --out: '{tmp_path / name}' does not end in .html or .pdf\n" or "..." in line
    with pytest.raises(UsageError, match="does not end in"):
        package.load(result).report(tmp_path / name)


def test_files_that_are_not_there(refused, result, tmp_path):
    gone = tmp_path / "gone"
    assert refused("report", gone) == f"tumble: {gone}: no such file or folder\n"
    for option in ("--template", "--logo", "--run"):
        assert f"{gone}: no such file or folder" in refused("report", result, option, gone)


def test_an_input_is_not_overwritten(refused, result, tmp_path):
    template = written(tmp_path, "own.html", "{{ number }}")
    line = refused("report", result, "--template", template, "--out", template)
    assert "is an input of this command" in line


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "{}", '{"schema": "tumble.plan/1"}', '{"schema": "tumble.result/1"}', b"\xed\xa0\x80"]
)  # fmt: skip
def test_what_is_no_result_is_refused(text, refused, tmp_path):
    file = written(tmp_path, "r.json", text)
    assert refused("report", file, "--out", tmp_path / "r.html").startswith(f"tumble: {file}: ")


def leaves(value, path=()):
    """Paths of everything in a document."""
    yield path
    for key, part in value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ():
        yield from leaves(part, (*path, key))


def test_a_document_with_anything_wrong_in_it_is_reported_or_refused(drawn):
    """Never a fault: each leaf in turn is gone, or of another kind. Drawn at random, the same every time."""
    document, rng = solve(limit_g=1e-6).document, random.Random(20)
    paths, outcomes = [path for path in leaves(document) if path], {"reported": 0, "refused": 0}
    for path in rng.sample(paths, 80):
        changed = copy.deepcopy(document)
        place = changed
        for key in path[:-1]:
            place = place[key]
        place[path[-1]] = rng.choice([None, "x", -1, 1e308, True, [], {}, [[]], {"a": 1}])
        try:
            Result(json.dumps(changed)).reported("html")
            outcomes["reported"] += 1
        except BadInput:
            outcomes["refused"] += 1
    assert min(outcomes.values()) > 5, outcomes


# Numbers.


def test_a_number_is_of_the_content_and_its_date(drawn):
    document = solve().document
    number = number_of(document)
    assert re.fullmatch(r"T-20231114-[0-9a-f]{12}", number)
    assert number_of(json.loads(json.dumps(document, indent=7, sort_keys=True))) == number
    others = {number_of({**document, key: "other"}) for key in document}
    assert len(others) == len(document) and number not in others
    assert number_of({**document, "created": None}).startswith("T-undated-")


def test_a_number_may_be_given(result, tmp_path, drawn):
    """It stands in the head, at the end and, for every page, in the style: as a text, whatever it holds."""
    number = 'No. 7/2026 "</style><script>\\'
    report = Report(package.load(result).reported("html", number=number).decode())
    assert plain(report.text).count('No. 7/2026 "</style><script>\\') == 2 and "script" not in report.tags
    (content,) = re.findall(r'@top-right \{ content: ("[^"]*")', report.style)
    assert content == css_string(number)
    unescaped = re.sub(r"\\([0-9a-f]+) ", lambda code: chr(int(code[1], 16)), content[1:-1])
    assert unescaped == number


@pytest.mark.parametrize("number", ["", "  ", "x" * 65, "two\nlines", "nul\0"])
def test_other_numbers_are_refused(number):
    with pytest.raises(UsageError, match="is not a text of 1 to 64 characters on one line"):
        require_number(number)


def test_a_script_is_told_of_its_arguments(result, tmp_path):
    """Not of options, which it does not have."""
    calls = {
        r"^number: a int is not a text of 1 to 64 characters on one line$": {"number": 12},
        r"^file: '.*' does not end in \.html or \.pdf$": {"file": tmp_path / "r.doc"},
        r"^a int is not the path of a file$": {"template": 7},
    }
    for said, arguments in calls.items():
        with pytest.raises(UsageError, match=said):
            package.load(result).report(**{"file": tmp_path / "r.html", **arguments})
    with pytest.raises(UsageError, match=r"^a int is not the path of a file$"):
        package.load(result).plot(12)


def test_a_run_without_a_hash_is_told_by_its_means(tmp_path):
    """A table has no bytes to hash: with the real pictures, which hold its means against those of the result."""
    run = package.read(EXAMPLES / "paper_stand.csv")
    table = {"mounting": run.mounting, "position": run.position, **dict(zip(("ux", "uy", "uz"), run.outputs.T))}
    found = solve()
    found.report(tmp_path / "r.html", run=table)
    assert 'id="samples"' in (tmp_path / "r.html").read_text(encoding="utf-8")
    with pytest.raises(UsageError, match=r"run: not that of the result, which has another mean at position 1\.1"):
        found.report(tmp_path / "other.html", run={**table, "ux": table["ux"] + 1e-3})
    assert not (tmp_path / "other.html").exists()


# Templates and logos.


def test_a_template_may_extend_the_own_one(result, tmp_path):
    """Its blocks have all that the own one has; what it says is escaped."""
    template = written(
        tmp_path, "house.html.j2",
        '{% extends "report.html.j2" %}\n{% from "tables.html.j2" import listing %}\n'
        "{% block identity %}<h2>Ours</h2>{{ document.estimator }} {{ '<b>' }} {{ listing(coefficients) }}\n"
        "{% endblock %}",
    )  # fmt: skip
    report = Report(package.load(result).reported("html", template=str(template)).decode())
    assert "Ours" in report.text and "refined <b>" in plain(report.text) and "Customer" not in report.text
    assert len([row for row in report.rows if row and row[0] == ["K_xx"]]) == 2


@pytest.mark.parametrize("extended", ["report.html.j2", "tumble/report.html.j2"])
def test_a_template_may_have_the_name_of_the_own_one(extended, result, tmp_path, monkeypatch):
    """It extends ours, and not itself without end. Rows of errors are its own."""
    monkeypatch.chdir(tmp_path)
    text = f'{{% extends "{extended}" %}}\n{{% block title %}}House{{% endblock %}}\n'
    written(tmp_path, "report.html.j2", text)
    report = Report(package.load(result).reported("html", template="report.html.j2").decode())
    assert "House" in report.text and report.text.count("Statement of conformity") == 1
    written(tmp_path, "report.html.j2", text.replace("House", "{{ 1 / 0 }}"))
    with pytest.raises(BadInput, match=r"^report\.html\.j2: row 2: not a template of a report: 'ZeroDivisionError"):
        package.load(result).reported("html", template="report.html.j2")


def test_a_template_may_be_one_s_own(result, tmp_path):
    said = "{{ number }}|{{ verdict.word }}|{{ document.K[0][0] }}|{{ figures|length }}"
    template = written(tmp_path, "own.txt", said)
    document = package.load(result).document
    text = package.load(result).reported("html", template=str(template)).decode()
    assert text == f"{number_of(document)}|PASS|{document['K'][0][0]}|3"


def test_the_page_lists_what_a_template_may_say(result, tmp_path):
    """The blocks of the own one, and every name that is handed to it."""
    page = (ROOT / "docs/files.md").read_text(encoding="utf-8").partition("## A template of your own")[2]
    page = page.partition("\n## ")[0]
    blocks = re.findall(r"{% block (\w+) %}", own("report.html.j2"))
    assert re.findall(r"`(\w+)`", page.split("of its blocks: ")[1].split(".")[0]) == blocks
    table = "".join(line.split("|")[1] for line in page.splitlines() if line.startswith("| `"))
    names = {name.split("[")[0] for name in re.findall(r"`([\w\[\]]+)`", table)}
    source = Source(package.load(result).document, "result")
    assert names == {*context(source, "1", None), "figures", "since", "history"}


BAD_TEMPLATES = {
    "{% block x %}": "row 1: not a template: ",
    "\n\n{{ 1 +* 2 }}": "row 3: not a template: ",
    "\n{{ nothing_such }}": "row 2: not a template of a report: \"UndefinedError: 'nothing_such' is undefined\"",
    "\n{{ document.nothing.such }}": "row 2: not a template of a report: ",
    "{{ 1 / 0 }}": "row 1: not a template of a report: 'ZeroDivisionError: division by zero'",
    "{{ ''.__class__.__mro__ }}": "row 1: not a template of a report: \"SecurityError: ",
    "{% include '/etc/passwd' %}": "row 1: not a template of a report: 'TemplateNotFound: /etc/passwd'",
    "{% for i in range(1000000000) %}{% endfor %}": "row 1: not a template of a report: 'OverflowError: ",
    b"\xff": "not a template: no text in UTF-8",
}


@pytest.mark.parametrize("text", BAD_TEMPLATES)
def test_a_bad_template_is_refused_in_a_line(text, result, tmp_path, capsys):
    template = written(tmp_path, "bad.j2", text)
    before = sorted(tmp_path.iterdir())
    code = main(["report", str(result), "--template", str(template), "--out", str(tmp_path / "r.html")])
    said = capsys.readouterr()
    assert (code, said.out, sorted(tmp_path.iterdir())) == (2, "", before)
    assert said.err.startswith(f"tumble: {template}: {BAD_TEMPLATES[text]}") and said.err.count("\n") == 1, said.err


@pytest.mark.parametrize(("data", "kind"), [(PNG, "png"), (b"\xff\xd8\xff\xe0 ... \xff\xd9", "jpeg"), (SVG, "svg+xml")])
def test_a_logo_stands_in_the_file_itself(data, kind, result, tmp_path):
    report = Report(package.load(result).reported("html", logo=str(written(tmp_path, "logo", data))).decode())
    assert report.links == [f"data:image/{kind};base64,{base64.b64encode(data).decode()}"]


@pytest.mark.parametrize(
    ("data", "why"), [(b"", "not a picture"), (b"GIF89a", "not a picture"), (PNG * 40000, "more than 2000000 bytes")]
)
def test_another_logo_is_refused(data, why, refused, result, tmp_path):
    logo = written(tmp_path, "logo.png", data)
    line = refused("report", result, "--logo", logo)
    assert line.startswith(f"tumble: {logo}: ") and why in line


# Packages that are not there, and those that are.


@pytest.mark.parametrize(
    ("missing", "out", "said"),
    [
        ("jinja2", "r.html", "a report needs jinja2: tools/setup report"),
        ("matplotlib", "r.html", "a report needs matplotlib: tools/setup report"),
        ("weasyprint", "r.pdf", "a report as PDF needs WeasyPrint and Pango: tools/setup report"),
    ],
)
def test_a_missing_package_is_named(missing, out, said, result, tmp_path, tumble):
    written(tmp_path, f"{missing}.py", f"raise ImportError('none', name={missing!r})\n")
    paths = f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"
    done = tumble("report", result, "--out", tmp_path / out, PYTHONPATH=paths)
    assert (done.returncode, done.stdout, done.stderr) == (77, "", f"tumble: {said}\n")
    assert not (tmp_path / out).exists()
    done = tumble("bench", "--report", "--out", tmp_path / "run", PYTHONPATH=paths) if out == "r.html" else None
    assert done is None or (done.returncode, (tmp_path / "run").exists()) == (77, False)


def test_without_a_package_a_bench_run_says_that_it_leaves_no_report(tmp_path, tumble):
    written(tmp_path, "jinja2.py", "raise ImportError('none', name='jinja2')\n")
    paths = f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"
    done = tumble("bench", "--out", tmp_path / "run", PYTHONPATH=paths, TUMBLE_NO_REPORT="")
    remedy = "tools/setup report"
    said = f"tumble: the run is made without a report: a report needs jinja2: {remedy}"
    said += "; --no-report leaves this line out"
    assert done.returncode == 0 and said in done.stderr.splitlines()
    assert not (tmp_path / "run/report.html").exists() and (tmp_path / "run/result.json").exists()
    done = tumble("bench", "--set", "no.such=1", "--out", tmp_path / "bad", PYTHONPATH=paths, TUMBLE_NO_REPORT="")
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1) and "no.such" in done.stderr


@pytest.mark.parametrize("option", ["--no-report", "--json", None])
def test_who_asks_for_none_gets_no_report(option, tmp_path, tumble, monkeypatch):
    """By option, by wanting JSON, and by the environment, which has it here."""
    monkeypatch.setenv("TUMBLE_NO_REPORT", "" if option else "1")
    done = tumble("bench", "--out", tmp_path / "run", *filter(None, [option]))
    assert done.returncode == 0 and "no report" not in done.stderr
    assert sorted(os.listdir(tmp_path / "run")) == ["bus.log", "inputs", "result.json", "run.csv"]


@pytest.mark.parametrize(("options", "code"), [((), 0), (("--report",), 2)])
def test_a_report_that_fails_costs_no_run(options, code, tmp_path, monkeypatch, capsys):
    """Unless it was asked for."""

    def fail(*_):
        raise BadInput("cannot be drawn", "result")

    monkeypatch.delenv("TUMBLE_NO_REPORT")
    monkeypatch.setattr(Result, "reported", fail)
    assert main(["bench", "--out", str(tmp_path / "run"), *options]) == code
    assert "result: cannot be drawn\n" in capsys.readouterr().err
    assert (tmp_path / "run/result.json").exists() == (code == 0)


def test_a_report_is_wanted_or_not(refused, tmp_path):
    said = refused("bench", "--report", "--no-report", "--out", tmp_path / "run")
    assert "not allowed with argument" in said


@pytest.mark.parametrize("changed", [{"augmented": "x"}, None])
def test_a_document_that_cannot_be_drawn_is_refused(changed, tmp_path, tumble):
    """Where it is read, whoever reads it."""
    document = solve().document
    document["stand_seen"] = None if changed is None else {**document["stand_seen"], **changed}
    (tmp_path / "odd.json").write_text(json.dumps(document))
    done = tumble("report", "odd.json", "--out", "odd.html", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "") and not (tmp_path / "odd.html").exists()
    assert done.stderr.startswith("tumble: odd.json: ") and done.stderr.count("\n") == 1
    with pytest.raises(BadInput, match=r"not a result of schema tumble\.result/1: stand_seen") as told:
        package.load(tmp_path / "odd.json")
    assert done.stderr == f"tumble: {told.value}\n".replace(f"{tmp_path}{os.sep}", "")


@pytest.mark.parametrize("key", ["means", "stand_seen", "noise"])
@pytest.mark.parametrize("odd", ["x", 1e200, [None]])
def test_pictures_of_a_damaged_document_are_refused_as_its_report_is(key, odd):
    """Also where the look at numbers meets what is none."""
    document = {**solve(stand=False).document, key: odd}
    for ask in (Result.plot, lambda result: result.reported("html")):
        with pytest.raises(BadInput, match=r"^result: "):
            ask(Result(json.dumps(document)))


@pytest.mark.toolchain
def test_with_its_pictures_a_report_is_one_file_and_always_the_same(tmp_path):
    """Two processes, which hash differently. Each picture once, in their order, no name in one a name in another."""
    from tumble.pictures import kinds

    solve().save(tmp_path / "result.json")
    arguments = ["report", tmp_path / "result.json", "--run", EXAMPLES / "paper_stand.csv"]
    texts = []
    for seed in ("1", "2"):
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        done = subprocess.run([sys.executable, "-m", "tumble", *arguments], capture_output=True, env=environment)
        assert (done.returncode, done.stderr) == (0, b"")
        texts.append(done.stdout)
    assert texts[0] == texts[1]
    report = Report(texts[0].decode())
    assert [link for link in report.links if not link.startswith(("data:", "#"))] == []
    assert [url for url in re.findall(r"url\(([^)]*)\)", report.source) if not url.startswith("#")] == []
    assert len(set(report.ids)) == len(report.ids) and report.tags.count("svg") == 8
    assert [one for one in report.ids if one in kinds()] == [one for one in kinds() if one != "inclinations"]


@pytest.mark.toolchain
def test_a_bench_run_leaves_the_report_on_its_result(tmp_path, tumble, monkeypatch):
    monkeypatch.delenv("TUMBLE_NO_REPORT")
    assert tumble("bench", "--out", tmp_path / "run").returncode == 0
    assert sorted(os.listdir(tmp_path / "run")) == ["bus.log", "inputs", "report.html", "result.json", "run.csv"]
    package.load(tmp_path / "run/result.json").report(tmp_path / "again.html", run=tmp_path / "run/run.csv")
    assert (tmp_path / "again.html").read_bytes() == (tmp_path / "run/report.html").read_bytes()
