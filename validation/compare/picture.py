"""Plot of a comparison: both images, their relative difference, and the results of the tests."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402


def encoded(image, scale):
    """Converts scaled linear values to sRGB."""
    x = np.clip(image * scale, 0, 1)
    x = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    return np.repeat(x, 3, axis=2) if x.shape[2] == 1 else x


def write(path, a, b, verdict):
    """Writes a PNG with four panels. `path`: a file or its name."""
    grey_a, grey_b = a.mean.mean(axis=2), b.mean.mean(axis=2)
    relative = (grey_a - grey_b) / (grey_b + 0.1 * max(grey_b.mean(), 1e-30))
    relative[a.masked | b.masked] = np.nan
    reach = max(float(np.nanpercentile(np.abs(relative), 99)), 1e-6)
    scale = 0.8 / max(float(np.percentile(b.mean, 98)), 1e-30)
    smallest = np.fmin.reduce(verdict.p_of_pixels, axis=2)
    tiles = verdict.t_of_tiles
    strongest = np.take_along_axis(tiles, np.abs(tiles).argmax(axis=2)[:, :, None], 2)[:, :, 0]

    figure, axes = plt.subplots(2, 2, figsize=(10, 8), constrained_layout=True)
    axes[0, 0].imshow(encoded(a.mean, scale), interpolation="nearest")
    axes[0, 0].set_title("A")
    axes[0, 1].imshow(encoded(b.mean, scale), interpolation="nearest")
    axes[0, 1].set_title("B, the reference")
    shown = axes[1, 0].imshow(relative, cmap="seismic", vmin=-reach, vmax=reach,
                              interpolation="nearest")
    axes[1, 0].set_title("(A - B) / (B + 0.1 mean B)")
    figure.colorbar(shown, ax=axes[1, 0])
    height, width = grey_a.shape
    shown = axes[1, 1].imshow(np.clip(strongest, -8, 8), cmap="seismic", vmin=-8, vmax=8,
                              extent=(0, strongest.shape[1] * 16, strongest.shape[0] * 16, 0),
                              interpolation="nearest")
    ys, xs = np.nonzero(smallest < 1e-4)
    axes[1, 1].plot(xs + 0.5, ys + 0.5, "k.", markersize=3)
    axes[1, 1].set(xlim=(0, width), ylim=(height, 0))
    axes[1, 1].set_title("t of tiles; dots: pixels with p < 1e-4")
    figure.colorbar(shown, ax=axes[1, 1])
    figure.suptitle("pass" if verdict.passed else "FAIL")
    figure.savefig(path, format="png", dpi=80, metadata={"Software": None})
    plt.close(figure)
