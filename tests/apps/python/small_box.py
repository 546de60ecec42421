"""A scene for tests of the Python module, which must be importable."""
import kinome as mi


def small_box(side=16, samples=4, **parts):
    """Returns the dict of a Cornell box with a small film."""
    box = mi.cornell_box()
    box["sensor"]["film"].update(width=side, height=side)
    box["sensor"]["sampler"]["sample_count"] = samples
    return {**box, **parts}
