"""Statistical comparison of renders: see kinome-compare."""
from .errors import Errors, flip
from .images import BadInput, Estimate, load
from .verdict import Verdict, compare

__all__ = ["BadInput", "Errors", "Estimate", "Verdict", "compare", "flip", "load"]
