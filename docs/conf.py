"""Sphinx, for the documentation site. tools/site builds it; which pages there are stands in site.toml."""

from pathlib import Path

from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.util import logging
from sphinx.util.docutils import SphinxTranslator

ROOT = Path(__file__).resolve().parents[1]

project = "Tumble"
author = "the authors of Tumble"
release = version = (ROOT / "VERSION").read_text(encoding="utf-8").strip()
root_doc = "index"
extensions = ["myst_parser", "sphinx.ext.autodoc"]

# Pages are Markdown as GitHub reads it: $formulas$, and headings that links reach by their words.
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 6
highlight_language = "none"

# Docstrings are plain text with `code` in single quotes.
default_role = "literal"
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 80
c_maximum_signature_line_length = 80
toc_object_entries_show_parents = "hide"

# Nothing comes from the network: furo has no fonts of its own, and formulas are MathML.
html_theme = "furo"
html_title = f"Tumble {release}"
html_math_renderer = "mathml"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_copyright = False


def show_formula(translator: SphinxTranslator, node: object) -> None:
    """In place of MathJax, which pages would fetch. What docutils cannot convert is a warning, so the build fails."""
    block = node.__class__.__name__ == "math_block"
    try:
        formula = tex2mathml(node.astext(), as_block=block)
    except (ValueError, SyntaxError) as error:
        logging.getLogger(__name__).warning("formula %s: %s", node.astext(), error, location=node)
        formula = translator.encode(node.astext())
    translator.body.append(f'<div class="formula">{formula}</div>\n' if block else formula)


def depart_formula(_translator: SphinxTranslator, _node: object) -> None:
    """All has been said."""


def setup(app: object) -> dict:
    def visit(translator, node):
        show_formula(translator, node)
        node.children = []

    app.add_html_math_renderer("mathml", (visit, depart_formula), (visit, depart_formula))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
