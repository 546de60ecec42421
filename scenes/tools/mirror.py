"""The mirror scene needs its photograph alone."""


def make(folder, scale):
    """There are no meshes."""
    return 0
