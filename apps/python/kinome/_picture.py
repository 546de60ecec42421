"""Results of renders."""
import collections.abc

import numpy as np

from . import _arguments as check
from . import _kinome


def _layer(channel):
    return channel.rpartition(".")[0] or channel


class Picture(np.ndarray):
    """A float32 array (height, width, channels), linear Rec.709, rows from the top.

    picture["albedo"] returns the channels albedo.R, albedo.G, albedo.B, or the channel of that name,
    without a copy if they are neighbours. picture.rgb is the colour. channels: names of the channels.
    stats: statistics of the render: "complete" (False if it was interrupted), "samples", "seconds",
    "relmse" (for error=).

    Results that keep all axes are Pictures with channels, too: crops and selections of channels
    (picture[10:20], picture[:, :, :3], picture[..., [0, 2]]), copies, and element-wise arithmetic,
    also with other pictures of the same channels. All other results have no names.
    Picture(array, channels) names the channels of any array.
    """

    def __new__(cls, array, channels, stats=None):
        self = np.asarray(array).view(cls)
        check.instance(channels, "channels", collections.abc.Iterable, "a list of names")
        channels = [check.instance(name, "a channel's name", str, "a string") for name in channels]
        if self.ndim != 3 or self.shape[2] != len(channels):
            raise ValueError("array takes the shape (height, width, channels), with "
                             f"{len(channels)} channels as there are names, got {self.shape}")
        self.channels, self.stats = channels, dict(stats or {})
        return self

    def __array_finalize__(self, other):
        # The caller sets the channels, because the shape doesn't show which of them are left.
        self.channels, self.stats = [], {}

    def __getitem__(self, key):
        if isinstance(key, str):
            return self._named(key)
        part = super().__getitem__(key)
        if not isinstance(part, Picture):
            return part
        names, is_whole = self._names_of(key)
        if names is None or part.ndim != 3 or part.shape[2] != len(names):
            return part.view(np.ndarray)
        return Picture(part, names, self.stats if is_whole else _of_part(self.stats))

    def _named(self, layer):
        found = [i for i, name in enumerate(self.channels)
                 if name == layer or name.startswith(layer + ".")]
        if not found:
            layers = ", ".join(dict.fromkeys(map(_layer, self.channels)))
            raise KeyError(f"{layer!r}: the picture has {layers or 'no names of channels'}")
        is_range = found[-1] - found[0] == len(found) - 1  # may be false after a selection of channels
        part = self.view(np.ndarray)[:, :, slice(found[0], found[-1] + 1) if is_range else found]
        return part[:, :, 0] if self.channels[found[0]] == layer else part

    def _names_of(self, key):
        """Returns the channels of self[key], or None if its last axis isn't that of the channels.
        Also returns True if self[key] has all pixels in their positions."""
        keys = list(key) if isinstance(key, tuple) else [key]
        dots = [i for i, one in enumerate(keys) if one is Ellipsis]
        if len(dots) > 1 or any(one is None for one in keys):
            return None, False
        at = dots[0] if dots else len(keys)
        keys[at:at + 1] = [slice(None)] * (3 - len(keys) + bool(dots))
        if len(keys) != 3 or not all(isinstance(one, slice) for one in keys[:2]):
            return None, False
        names = np.array(self.channels, object)[keys[2]] if self.channels else None
        is_whole = all(one.indices(size) == (0, size, 1)
                       for one, size in zip(keys, self.shape[:2]))
        return names.tolist() if isinstance(names, np.ndarray) else None, is_whole

    def __array_ufunc__(self, function, method, *inputs, out=None, **options):
        def plain(values):
            return [value.view(np.ndarray) if isinstance(value, Picture) else value
                    for value in values]
        if out is not None:
            options["out"] = tuple(plain(out))
        result = getattr(function, method)(*plain(inputs), **options)
        if out is not None:
            return out[0] if len(out) == 1 else out
        pictures = [value for value in inputs if isinstance(value, Picture)]
        by_number = method == "__call__" and function.signature is None
        if (not by_number or not isinstance(result, np.ndarray) or
                any(p.channels != self.channels or p.shape != result.shape for p in pictures)):
            return result
        return self._like(result)

    def _like(self, array, stats=None):
        """Returns a Picture of `array` with this picture's channels, if it has any."""
        if not self.channels:
            return array
        return Picture(array, self.channels, stats)

    def copy(self, order="C"):
        """Returns a copy that keeps the channels' names."""
        return self._like(super().copy(order), self.stats)

    def astype(self, dtype, *arguments, **options):
        """Converts the values and keeps the channels' names."""
        return self._like(super().astype(dtype, *arguments, **options), self.stats)

    def __copy__(self):
        return self.copy()

    def __deepcopy__(self, memo):
        return self.copy()

    def __reduce__(self):
        return _unpickled, (np.asarray(self), self.channels, self.stats)

    @property
    def rgb(self):
        """The colour, without alpha and layers."""
        for names in (["R", "G", "B"], ["Y"]):
            if self.channels[:len(names)] == names:
                return self.view(np.ndarray)[:, :, :len(names)]
        raise ValueError("there is no colour among the channels of this array: "
                         f"{', '.join(self.channels) or 'they have no names'}")

    @property
    def layers(self):
        """Names of the layers besides the colour."""
        return list(dict.fromkeys(_layer(name) for name in self.channels
                                  if name not in ("R", "G", "B", "A", "Y")))

    def _repr_png_(self):
        """Returns the bytes of a PNG file, which notebooks show. None if there is no colour."""
        colors = [name for name in ("R", "G", "B", "A") if name in self.channels]
        if colors[:3] != ["R", "G", "B"]:
            colors = [name for name in ("Y", "A") if name in self.channels]
        if self.ndim != 3 or self.size == 0 or colors[:1] not in (["R"], ["Y"]):
            return None
        pixels = self.view(np.ndarray)[..., [self.channels.index(name) for name in colors]]
        return _kinome.encode_picture(np.ascontiguousarray(pixels, np.float32), colors)

    def write(self, path):
        """Writes a file in the format of its extension: .exr with all channels in single precision,
        or a format that Bitmap.write() supports. Raises kinome.Error for a file that a loaded scene
        reads."""
        if not self.channels:
            raise ValueError("this array's channels have no names: Picture(array, channels) gives it "
                             "some")
        path = check.path(path, "path")
        if not path.lower().endswith((".exr", ".pfm", ".png")):
            from ._bitmap import Bitmap
            return Bitmap(self).write(path)
        header = {}
        if self.stats:
            header = {"kinome:complete": "true" if self.stats.get("complete", True) else "false",
                      "kinome:samples": f"{self.stats.get('samples', 0):g}",
                      "kinome:seed": str(self.stats.get("seed", 0))}
        if self.stats.get("denoised"):
            header["kinome:denoised"] = "image"
        if self.stats.get("renders"):
            header["kinome:renders"] = str(self.stats["renders"])
            header["kinome:variance_of_mean"] = " ".join(
                f"{v:.9g}" for v in self.stats["variance_of_mean"])
        if any(name.startswith("Crypto") for name in self.channels):
            header.update(self.stats.get("cryptomatte", {}))
        _kinome.write_picture(path, np.ascontiguousarray(self, np.float32),
                              self.channels, header)


def _of_part(stats):
    """Returns the statistics that are still valid for a part of the image."""
    return {key: value for key, value in stats.items()
            if key not in ("relmse", "renders", "variance_of_mean")}


def _unpickled(array, channels, stats):
    return Picture(array, channels, stats) if channels else array
