"""The mirror scene needs only its photograph."""


def make(folder, scale):
    """There are no meshes."""
    return 0
