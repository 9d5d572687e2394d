"""Notebooks of docs/: as pages of the site, with the outputs that are stored in them; and executed anew."""

import base64
import json
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PICTURE, TABLE = "image/png", "text/html"
TIMEOUT_S = 300


def as_markdown(file, place):
    """Markdown of a notebook with its stored outputs; its pictures become PLACE-1.png, ..."""
    parts, pictures = [], 0
    for cell in json.loads(file.read_text(encoding="utf-8"))["cells"]:
        source = "".join(cell["source"])
        parts.append(source if cell["cell_type"] == "markdown" else f"```python\n{source}\n```")
        for output in cell.get("outputs", []):
            if is_picture(output):
                pictures += 1
                drawn = Path(f"{place}-{pictures}.png")
                drawn.parent.mkdir(parents=True, exist_ok=True)
                drawn.write_bytes(base64.b64decode("".join(output["data"][PICTURE])))
                parts.append(f"![What these lines draw]({drawn.name})")
            elif TABLE in output.get("data", {}):
                parts.append(f'<div class="result">\n{text_of(output)}\n</div>')
            else:
                parts.append(f"```text\n{text_of(output).rstrip()}\n```")
    return "\n\n".join(parts) + "\n"


def is_picture(output):
    return PICTURE in output.get("data", {})


def text_of(output):
    """What an output says, in HTML if it can. Raises KeyError for one that is neither text nor picture: an error."""
    return "".join(output["text"] if "text" in output else output["data"].get(TABLE) or output["data"]["text/plain"])


def told(file):
    """What the cells of a notebook have said, a text each. Pictures are left out: fonts differ between machines."""
    cells = json.loads(file.read_text(encoding="utf-8"))["cells"]
    return [[text_of(output) for output in cell["outputs"] if not is_picture(output)]
            for cell in cells if cell["cell_type"] == "code"]  # fmt: skip


def execute(file, out):
    """Execute a notebook in the root of the repository, and write it with its outputs to `out`. Needs nbclient and
    ipykernel. An exception in a cell is raised."""
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.read(file, as_version=4)
    resources = {"metadata": {"path": str(ROOT)}}
    # A slow kernel sends one print in pieces.
    NotebookClient(notebook, timeout=TIMEOUT_S, resources=resources, coalesce_streams=True).execute()
    notebook.metadata["language_info"] = {"name": "python"}  # without the version, which differs between machines
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)  # when it ran
    nbformat.write(notebook, out)
