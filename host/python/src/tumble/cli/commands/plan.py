"""`tumble plan ...`: what a stand is worth, before anything is measured on it."""

from __future__ import annotations

from tumble.cli.commands import (
    plan_budget,
    plan_optimize,
    plan_paper,
    plan_require,
    plan_schedule,
    plan_validate,
)
from tumble.cli.options import Subparsers, add_subjects

# each is a module with add_to(subparsers), as a command is
_SUBJECTS = (plan_budget, plan_require, plan_optimize, plan_schedule, plan_validate, plan_paper)


def add_to(subparsers: Subparsers, about: str) -> None:
    """Describe the command and its subjects to argparse."""
    subjects = add_subjects(
        subparsers,
        "plan",
        about,
        "What a stand is worth, before anything is measured on it.",
    )
    for subject in _SUBJECTS:
        subject.add_to(subjects)
