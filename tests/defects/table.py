"""The defects: each changes the code in one location, and a test must notice it. The rows are in
*_defects.py.

`source` is a file of the core or of a plugin. `old` is a part of it that occurs exactly once (any
run of white space matches any other). `new` replaces it while the defect is planted. `new` is an
expression if `old` is one that may be put in parentheses. Otherwise it is the whole part in its new
form, in which DEFECT is true while the defect is planted, and false otherwise. `test` is a test
program, and `pattern` a GoogleTest filter: these tests must fail then.
"""
import dataclasses

from clustered_defects import CLUSTERED_DEFECTS
from core_defects import CORE_DEFECTS
from plugin_defects import PLUGIN_DEFECTS
from product_defects import PRODUCT_DEFECTS
from transport_defects import TRANSPORT_DEFECTS


@dataclasses.dataclass(frozen=True)
class Defect:
    name: str
    source: str
    old: str
    new: str
    test: str
    pattern: str


DEFECTS = [Defect(*row) for row in CORE_DEFECTS + PLUGIN_DEFECTS + TRANSPORT_DEFECTS +
           CLUSTERED_DEFECTS + PRODUCT_DEFECTS]
