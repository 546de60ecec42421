"""Measures of error: relMSE without the reference's noise, and FLIP."""
import dataclasses

import numpy as np


@dataclasses.dataclass
class Errors:
    """relMSE = mean[((I - R)² - var R) / (R² + 0.01 mean(R)²)] over all values that aren't masked.

    trimmed: without the largest 0.1 % of the values; maximum: the largest value.
    """

    relmse: float
    trimmed: float
    maximum: float

    @classmethod
    def of(cls, image, reference, masked):
        """Returns the errors of an array against an Estimate. They have a mean of 0 for an exact image, so
        they may be slightly negative."""
        r = reference.mean[~masked]
        floor = 0.01 * r.mean() ** 2
        if floor == 0 and not r.any():
            floor = 1.0  # a black reference: absolute errors
        values = np.sort((((image[~masked] - r) ** 2 - reference.variance[~masked]) /
                          (r ** 2 + floor)).ravel())
        kept = len(values) - int(np.ceil(len(values) / 1000))
        return cls(float(values.mean()), float(values[:max(kept, 1)].mean()), float(values[-1]))


def flip(image, reference, masked):
    """Returns the mean HDR-FLIP, or None if the package flip-evaluator isn't installed, or if the
    reference is black: HDR-FLIP chooses its exposures by the reference's brightness."""
    try:
        import flip_evaluator  # not a package of Debian
    except ImportError:
        return None
    pictures = []
    for picture in (reference, image):
        picture = np.where(masked[:, :, None], 0, picture)
        if picture.shape[2] == 1:
            picture = np.repeat(picture, 3, axis=2)
        pictures.append(np.maximum(picture, 0).astype(np.float32))
    if not pictures[0].any():
        return None  # flip_evaluator would end the process
    return float(flip_evaluator.evaluate(*pictures, "HDR")[1])
