"""A run as it goes, for people who look on: on a terminal or as a page in a browser. Whoever watches changes nothing.

A source (`snapshot.Source`) is asked again and again by a `runs.Follower`; `terminal` and `server` show what it
has found.
"""
