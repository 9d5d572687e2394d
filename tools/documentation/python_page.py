"""The page of the Python package: the docstrings of all public names."""

import inspect

INTRODUCTION = """\
# Python

All public names of the package `tumble`, `import tumble`, of `tumble.client` and of `tumble.history`.
[Scripts in Python](../client.md) shows how they are used.
Version {version}.
"""
# Of whatever kind, as Sphinx calls it: its title, and which members are shown.
KINDS = {
    "autofunction": ("Functions", []),
    "autoclass": ("Classes", [":members:"]),
    "autoexception": ("Exceptions", [":show-inheritance:"]),
    "py:data": ("Tables", []),
}


def page():
    """Markdown of the page: Sphinx puts the docstrings in."""
    import tumble
    from tumble import client, history

    text = [INTRODUCTION.format(version=tumble.__version__), *sections(tumble, "")]
    text += sections(client, " of tumble.client")
    return "\n".join([*text, *sections(history, " of tumble.history")])


def sections(module, of):
    """The public names of a module, a section for each kind."""
    for kind, (title, options) in KINDS.items():
        names = [f"{module.__name__}.{name}" for name in module.__all__ if kind_of(getattr(module, name)) == kind]
        lines = [line for name in names for line in (f".. {kind}:: {name}", *(f"   {o}" for o in options), "")]
        if kind == "py:data":  # a module below another name, of which autodoc knows nothing
            told = [inspect.getdoc(getattr(module, name.rpartition(".")[2])).splitlines() for name in names]
            lines = [line for name, own in zip(names, told) for line in (f".. {kind}:: {name}", "", *indented(own), "")]
        if names:
            yield "\n".join([f"## {title}{of}", "", "```{eval-rst}", *lines, "```", ""])


def indented(lines):
    """Within a directive."""
    return [f"   {line}".rstrip() for line in lines]


def kind_of(value):
    """Which of KINDS it is; None: text, such as the version."""
    if inspect.isclass(value):
        return "autoexception" if issubclass(value, Exception) else "autoclass"
    if inspect.ismodule(value):
        return "py:data"
    return "autofunction" if inspect.isfunction(value) else None
