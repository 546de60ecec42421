"""What a render gives."""
import numpy as np

from . import _kinome


class Picture(np.ndarray):
    """A float32 array (height, width, channels), linear Rec.709, rows from the top.

    picture["albedo"] is the part of the channels albedo.R, albedo.G, albedo.B, or the one channel
    of that name, without a copy; picture.rgb the colour. channels: their names. stats: how it was
    made, "complete" (whether nothing stopped it), "samples", "seconds", "relmse" (where error= asked).
    """

    def __new__(cls, array, channels, stats):
        self = np.asarray(array).view(cls)
        self.channels, self.stats = list(channels), dict(stats)
        return self

    def __array_finalize__(self, other):
        self.channels = getattr(other, "channels", [])
        self.stats = getattr(other, "stats", {})

    def __getitem__(self, key):
        if not isinstance(key, str):
            part = super().__getitem__(key)
            return part.view(np.ndarray) if isinstance(part, Picture) else part
        found = [i for i, name in enumerate(self.channels)
                 if name == key or name.startswith(key + ".")]
        if not found:
            layers = sorted({name.rpartition(".")[0] or name for name in self.channels})
            raise KeyError(f"{key!r}: the picture has {', '.join(layers)}")
        part = self.view(np.ndarray)[:, :, found[0]:found[-1] + 1]
        return part[:, :, 0] if self.channels[found[0]] == key else part

    @property
    def rgb(self):
        """The colour, without alpha and layers."""
        count = 3 if self.channels[:3] == ["R", "G", "B"] else 1
        return self.view(np.ndarray)[:, :, :count]

    @property
    def layers(self):
        """Names of what is beside the colour."""
        return list(dict.fromkeys(name.rpartition(".")[0] or name for name in self.channels
                                  if name not in ("R", "G", "B", "A", "Y")))

    def write(self, path):
        """As .exr (with all channels, in single precision), .pfm or .png (8 bits, sRGB)."""
        header = {"kinome:complete": "true" if self.stats.get("complete", True) else "false",
                  "kinome:samples": f"{self.stats.get('samples', 0):g}",
                  "kinome:seed": str(self.stats.get("seed", 0))}
        if self.stats.get("renders"):
            header["kinome:renders"] = str(self.stats["renders"])
            header["kinome:variance_of_mean"] = " ".join(
                f"{v:.9g}" for v in self.stats["variance_of_mean"])
        _kinome.write_picture(str(path), np.ascontiguousarray(self, np.float32), self.channels,
                              header)
