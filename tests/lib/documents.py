"""What `tumble ... --json` prints, held against its schema; and the paper's stand file with something changed."""

import functools
import json
import re
from pathlib import Path

import jsonschema
import referencing

NO_GRAVITY = (
    "no coefficients in m/s2: its environment has no gravity_m_s2; write the local gravity, such as "
    "gravity_m_s2 = 9.81, under [environment] of the stand file, and solve again"
)
_ROOT = Path(__file__).resolve().parents[2]


SCHEMAS = _ROOT / "docs/schemas"


def schema(kind):
    """Of a result, a plan or a fixture."""
    return json.loads((SCHEMAS / f"tumble.{kind}-1.schema.json").read_text())


def registry(folder=SCHEMAS):
    """All schemas of a folder by their `$id`. Nothing else is found: nothing is fetched."""
    found = [json.loads(path.read_text()) for path in sorted(folder.glob("*.json"))]
    return referencing.Registry().with_contents([(one["$id"], one) for one in found])


@functools.cache
def validator(kind):
    return jsonschema.Draft202012Validator(schema(kind), registry=registry())


def valid(text, kind="result"):
    """The document of this text: JSON to the letter, which has no NaN, and valid by its schema."""

    def refuse(name):
        raise ValueError(name)

    document = json.loads(text, parse_constant=refuse)
    validator(kind).validate(document)
    return document


def document_of(done, kind="result", codes=(0,)):
    """The document of a command that had nothing to warn of."""
    assert done.returncode in codes and done.stderr == "", (done.returncode, done.stderr)
    return valid(done.stdout, kind)


def paper_stand(folder, more="", block="", **values):
    """stand.toml of the paper with these values, with lines more in [block], and with `more` at its end."""
    text = (_ROOT / "examples/paper_stand.toml").read_text()
    for key, value in values.items():
        text, found = re.subn(rf"(?m)^{key} = .*$", f"{key} = {value}", text)
        assert found == 1, key
    path = Path(folder) / "stand.toml"
    path.write_text(text.replace("[block]\n", f"[block]\n{block}") + more, encoding="utf-8")
    return path
