"""`tumble plan ...`: what a stand is worth, before anything is measured on it."""

from __future__ import annotations

from tumble.commands import plan_budget, plan_optimize, plan_paper, plan_require, plan_validate

# each is a module with add_to(subparsers), as a command is
_SUBJECTS = (plan_budget, plan_require, plan_optimize, plan_validate, plan_paper)


def add_to(subparsers) -> None:
    """Describe the command and its subjects to argparse."""
    parser = subparsers.add_parser(
        "plan",
        help="what a stand is worth before a run: error budget, requirements, optimal weights",
        description="What a stand is worth, before anything is measured on it.",
    )
    subjects = parser.add_subparsers(metavar="SUBJECT", required=True)
    for subject in _SUBJECTS:
        subject.add_to(subjects)
