"""Pictures of a result, and of two results, with matplotlib, for `Result.plot`, reports and pages.

figures     all that a result has what it takes for, by name; kinds: these names
svg         a figure to stand in a page of HTML
CAPTIONS    a sentence or two for each; caption: for that of a document
comparison  two calibrations of one block

They are as wide as the text of a page of A4, and may be read without colours. matplotlib is loaded when it is used.

gallery       which pictures there are, and what each needs
canvas        matplotlib, sizes, colours, files
facts         what the pictures of one result are made from
by_position   gravity check and residuals; samples: of the run; shares: the budget; stand_seen; matrix: correlation;
              sphere: attitude
"""

from tumble.pictures.canvas import require, require_format, written
from tumble.pictures.comparison import comparison
from tumble.pictures.gallery import CAPTIONS, caption, figures, kinds, svg

__all__ = ["CAPTIONS", "caption", "comparison", "figures", "kinds", "require", "require_format", "svg", "written"]
