"""The assets of the wax scene: the statue and the plinth of the hebe scene."""

from .hebe import make

__all__ = ["make"]
