"""Are two calibrations of one block the same?

verdict    neither has changed, the seat, the block, or nobody can tell: parameters, tests of their differences
pair       from two results to a comparison, with what both share of one stand
report     a comparison as a document of schema tumble.comparison/1, and for people
"""
