"""What `tumble ... --json` prints, held against its schema; and the paper's stand file with something changed."""

import json
import re
from pathlib import Path

import jsonschema

NO_GRAVITY = (
    "no coefficients in m/s2: its environment has no gravity_m_s2; write the local gravity, such as "
    "gravity_m_s2 = 9.81, under [environment] of the stand file, and solve again"
)
_ROOT = Path(__file__).resolve().parents[2]


def schema(kind):
    """Of a result, a plan or a fixture."""
    return json.loads((_ROOT / f"docs/schemas/tumble.{kind}-1.schema.json").read_text())


def valid(text, kind="result"):
    """The document of this text: JSON to the letter, which has no NaN, and valid by its schema."""

    def refuse(name):
        raise ValueError(name)

    document = json.loads(text, parse_constant=refuse)
    jsonschema.Draft202012Validator(schema(kind)).validate(document)
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
