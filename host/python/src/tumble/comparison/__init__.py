"""Are two calibrations of one block the same?

statistics    tests of the difference
verdict       neither, the seat, the block, or nobody can tell
shared        one of the two calibrations, and what both share of one stand
pair          from two results to a comparison
report        a comparison as a document of schema tumble.comparison/1, and for people
"""
