"""Sphinx, for the documentation site. tools/site builds it; which pages there are stands in site.toml."""

import re
from dataclasses import is_dataclass
from inspect import isclass
from pathlib import Path

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.util import logging

ROOT = Path(__file__).resolve().parents[1]
OPERATOR = re.compile(r"<mi>(arctan|cos|det|exp|max|min|sin|tan)</mi>")  # latex2mathml leaves no space beside them

project = "Tumble"
author = "the authors of Tumble"
release = version = (ROOT / "VERSION").read_text(encoding="utf-8").strip()
root_doc = "index"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_copybutton"]

# Pages are Markdown as GitHub reads it: $formulas$, and headings that links reach by their words.
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 6
highlight_language = "none"
smartquotes = False  # they make a dash of --json

# Docstrings are plain text with `code` in single quotes.
default_role = "literal"
napoleon_google_docstring = False  # sections are those of numpydoc
napoleon_use_rtype = False
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
autodoc_type_aliases = {"Floats": "ndarray", "Integers": "ndarray", "ArrayLike": "ArrayLike"}
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
html_search_scorer = str(ROOT / "docs/static/search.js")  # how results are ranked
html_copy_source = False

# Commands are copied without their prompts, and without what they print.
copybutton_prompt_text = r"\$ |>>> |\.\.\. "
copybutton_prompt_is_regexp = True
copybutton_line_continuation_character = "\\"
html_show_copyright = False


def visit_formula(translator, node):
    """In place of MathJax, which pages would fetch. A formula that cannot be converted is a warning, and fails."""
    block = isinstance(node, nodes.math_block)
    source = node.astext()
    try:
        formula = convert(source, display="block" if block else "inline")
        fault = "a command that latex2mathml does not know" if "\\" in formula else ""
    except Exception as error:  # its exceptions have no class in common
        formula, fault = translator.encode(source), repr(error)
    if fault:
        logging.getLogger(__name__).warning("formula %s: %s", source, fault, location=node)
    formula = OPERATOR.sub(r'<mo lspace="0.17em" rspace="0.17em">\1</mo>', formula)
    translator.body.append(f'<div class="formula">{formula}</div>\n' if block else formula)
    raise nodes.SkipNode


def hide_constructor(_app, _what, _name, value, _options, signature, _returned):
    """Of what the package makes and no caller does, results and exceptions: all classes that are no plain data."""
    return ("", None) if signature and isclass(value) and not is_dataclass(value) else None


def setup(app):
    app.connect("autodoc-process-signature", hide_constructor)
    app.add_html_math_renderer("mathml", (visit_formula, None), (visit_formula, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
