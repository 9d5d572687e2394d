"""The calibrations of many blocks over years: what they did, whether they behave, and when the next one is due.

calibrations  a result as a row: intrinsic parameters, seat, their uncertainties
database      the rows in SQLite, PostgreSQL or whatever SQLAlchemy reaches
trend         growth of a type, control charts of its blocks, what an alarm is
due           the day at which a limit is no longer sure to be kept
report        all of that as documents and as text
history       class `History`, the door for scripts
"""

from tumble.history.history import History

__all__ = ["History"]
