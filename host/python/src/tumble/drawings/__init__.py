"""Drawings of what one does with one's hands, as SVG: the stand, how the block sits, the angles, a run, the bus.

Pure geometry: every line follows from the schedule's matrices and angles, or from the firmware's own tables. Each
function returns the text of an SVG file, at most 170 mm wide, the same bytes for the same schedule, on a white page of
its own, with a title and a description in words. `words` tells the same poses on a terminal.
"""

from tumble.drawings.angle_views import angles
from tumble.drawings.bus_view import wiring
from tumble.drawings.mounting_views import mountings
from tumble.drawings.run_view import states
from tumble.drawings.stand_view import stand

__all__ = ["angles", "mountings", "stand", "states", "wiring"]
