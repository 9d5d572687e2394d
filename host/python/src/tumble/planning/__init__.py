"""What a stand is worth before anything is measured on it: for `tumble plan`, and for what a limit needs of a stand.

    case              what is planned for
    budget, weights   what each source of error leaves of the accuracy
    require           how bad each source may be, and how much worse it may become
    optimize          a gain table for a stand
    promise           the probability that a run passes, and that |a| is within the limit
    schedule_search   the quickest schedule for a wanted accuracy
    validate          Monte Carlo, and the verdict on it
    paper             the paper, computed again, and where it does not agree with itself

The paper's own numbers stand in `weights`.
"""
