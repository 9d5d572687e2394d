"""What a stand is worth before anything is measured on it: for `tumble plan`, and for what a limit needs of a stand.

    case              what is planned for
    budget, weights   what each source of error leaves of the accuracy
    require, headroom how bad each source may be, and how much worse it may become
    optimize          a gain table for a stand
    validate          Monte Carlo, judged by verdict
    paper             the paper (published), computed again; discrepancies says where it does not agree with itself

Modules named *_report turn what was found into JSON and tables.
"""
