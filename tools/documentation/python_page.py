"""The page of the Python package: the docstrings of all public names."""

import inspect

INTRODUCTION = """\
# Python

All public names of the package `tumble`, `import tumble`. [Calibrate in Python](../python.md) shows how they are used.
Version {version}.
"""
# Of whatever kind, as Sphinx calls it: its title, and which members are shown.
KINDS = {
    "autofunction": ("Functions", []),
    "autoclass": ("Classes", [":members:"]),
    "autoexception": ("Exceptions", [":show-inheritance:"]),
}


def page():
    """Markdown of the page: Sphinx puts the docstrings in."""
    import tumble

    sections = [INTRODUCTION.format(version=tumble.__version__)]
    for kind, (title, options) in KINDS.items():
        names = [name for name in tumble.__all__ if kind_of(getattr(tumble, name)) == kind]
        lines = [line for name in names for line in (f".. {kind}:: tumble.{name}", *(f"   {o}" for o in options), "")]
        sections.append("\n".join([f"## {title}", "", "```{eval-rst}", *lines, "```", ""]))
    return "\n".join(sections)


def kind_of(value):
    """Which of KINDS it is; None: text, such as the version."""
    if inspect.isclass(value):
        return "autoexception" if issubclass(value, Exception) else "autoclass"
    return "autofunction" if inspect.isfunction(value) else None
