"""All pictures, with matplotlib: of results, for `Result.plot`, reports and pages; and drawings of stand, run and bus.

figures      all that a result has what it takes for, by name; kinds: these names
CAPTIONS     a sentence or two for each; caption: for that of a document
comparison   two calibrations of one block
trend, control_chart    all calibrations of one block
thermal.figures         a calibration over temperature
stand, mountings, angles, inclinations    what one does with one's hands, by a schedule
states, wiring              the run and the bus, by the firmware's own tables
svg          a picture as an element of a page of HTML, or a file of its own; written: as .png, .svg or .pdf

They are as wide as the text of a page of A4, and may be read without colours. matplotlib is loaded when it is used.

gallery      which pictures there are of a result, and what each needs
canvas       matplotlib, sizes, colours, files; the page of a drawing
result       by position, by sample, the stand and its inclinations as they are seen
uncertainty  budget, correlation, attitude
recording    what is imported
history      one block over years
thermal      one block over temperature
histograms   of a simulated campaign
drawings     stand, mountings, angles, inclinations
diagrams     states, wiring
"""

from tumble.pictures import thermal
from tumble.pictures.canvas import require, require_format, svg, written
from tumble.pictures.comparison import comparison
from tumble.pictures.diagrams import states, wiring
from tumble.pictures.drawings import angles, inclinations, mountings, stand
from tumble.pictures.gallery import CAPTIONS, caption, figures, kinds
from tumble.pictures.history import control_chart, trend

__all__ = [
    "CAPTIONS",
    "angles",
    "caption",
    "comparison",
    "control_chart",
    "figures",
    "inclinations",
    "kinds",
    "mountings",
    "require",
    "require_format",
    "stand",
    "states",
    "svg",
    "thermal",
    "trend",
    "wiring",
    "written",
]
