"""What a stand is worth before anything is measured on it: for `tumble plan`, and for what a limit needs of a stand.

    case              what is planned for
    budget, weights   what each source of error leaves of the accuracy
    require           how bad each source may be, and how much worse it may become
    optimize          a gain table for a stand
    promise           the probability that a run passes, and that |a| is within the limit
    model_cost        what further terms cost: how well each is found, and what the twelve coefficients lose
    schedule_search   the quickest schedule for a wanted accuracy
    validate          Monte Carlo, and the verdict on it
    tables            plans for people, at most 80 columns wide
    paper             the paper, computed again, and where it does not agree with itself

The paper's own numbers stand in `weights`.
"""
