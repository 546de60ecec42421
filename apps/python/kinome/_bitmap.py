"""Images with a pixel format, as Mitsuba's Bitmap."""
import os
import tempfile

import numpy as np

from . import _arguments as check
from . import _color, _kinome
from ._color import AlphaTransform, PixelFormat, Struct
from ._errors import Error
from ._object import load_object


_LINEAR = (".tif", ".tiff", ".fits")  # formats of OpenImageIO that store floats
_WITHOUT_ALPHA = (".jpg", ".jpe", ".jpeg", ".jif", ".jfif", ".jfi", ".bmp", ".dib", ".ppm", ".pgm",
                  ".pbm", ".pnm")
_GREY = (".pgm", ".pbm")
_OF_COUNT = {1: PixelFormat.Y, 2: PixelFormat.YA, 3: PixelFormat.RGB, 4: PixelFormat.RGBA}
_FILTER_VALUES = 4097  # per filter, from its centre to its edge


def _images():
    from . import _images as images  # loads OpenImageIO, which takes a quarter of a second
    return images


def _call(function, path, *arguments):
    """Calls a function of OpenImageIO for a file."""
    try:
        return function(path, *arguments)
    except RuntimeError as reason:
        raise Error(f"{path}: {reason}", str(reason), path, 0, 0) from None


class Bitmap:
    """An image: an array (height, width, channels), rows from the top, with a pixel format.

    Bitmap(path) reads a file. Bitmap(array) takes a numpy array or a Picture of two or three axes,
    whose number of channels gives the pixel format: Y, YA, RGB, RGBA, or otherwise MultiChannel.
    numpy.array(bitmap) is a copy of the pixels, without the last axis if there is one channel. Bytes
    are encoded in sRGB, other types are linear, unless srgb_gamma() says otherwise.
    """

    PixelFormat, AlphaTransform = PixelFormat, AlphaTransform
    UInt8, Int8, UInt16, Int16 = (Struct.Type[name] for name in ("UInt8", "Int8", "UInt16", "Int16"))
    UInt32, Int32, UInt64, Int64 = (Struct.Type[name] for name in
                                    ("UInt32", "Int32", "UInt64", "Int64"))
    Float16, Float32, Float64 = (Struct.Type[name] for name in ("Float16", "Float32", "Float64"))

    def __init__(self, source, pixel_format=None, channel_names=()):
        self._metadata = {}
        self._is_premultiplied = True
        names = [check.instance(name, "a channel's name", str, "a string") for name in channel_names]
        is_path = isinstance(source, (str, bytes, os.PathLike))
        if (is_path or isinstance(source, Bitmap)) and (pixel_format is not None or names):
            raise ValueError("pixel_format and channel_names are only for arrays: call convert()")
        if is_path:
            self._read(check.path(source, "source"))
            return
        if isinstance(source, Bitmap):
            self.__dict__.update(source._like(source._array.copy()).__dict__)
            return
        try:
            array = np.asarray(source)
        except ValueError:  # rows of different lengths
            array = np.empty(0)
        if array.ndim == 2:
            array = array[:, :, None]
        if array.ndim != 3 or array.size == 0 or array.dtype.name not in (
                one.value for one in Struct.Type):
            raise check.fault(TypeError, "source", "a path, or numbers of the shape (height, width) "
                              "or (height, width, channels)", source)
        names = names or list(getattr(source, "channels", ()))
        self._metadata = dict(getattr(source, "stats", {}).get("cryptomatte", {}))
        self._set(np.array(array), names, pixel_format)

    def _set(self, array, names, pixel_format=None):
        """Sets the pixels. Chooses the pixel format by the names or the number of channels."""
        count = array.shape[2]
        if pixel_format is None:
            known = {tuple(one.value): one for one in PixelFormat if one.value}
            pixel_format = (known.get(tuple(names), PixelFormat.MultiChannel) if names else
                            _OF_COUNT.get(count, PixelFormat.MultiChannel))
        check.instance(pixel_format, "pixel_format", PixelFormat, "a PixelFormat")
        names = names or list(pixel_format.value) or [f"ch{i}" for i in range(count)]
        if len(names) != count or (pixel_format.value and len(pixel_format.value) != count):
            raise ValueError(f"pixel_format {pixel_format.name} and {len(names)} names don't fit "
                             f"{count} channels")
        self._array, self._names, self._format = array, names, pixel_format
        self._is_encoded = array.dtype == np.uint8

    def _read(self, path):
        if not os.path.isfile(path):
            reason = ("it is a folder, not a file" if os.path.isdir(path) else
                      "it is not a regular file" if os.path.exists(path) else "no such file")
            raise Error(f"{path}: {reason}", reason, path, 0, 0)
        array, names, metadata = _call(_images().read, path)
        self._metadata = metadata
        if (array.dtype.kind == "f" or array.shape[2] > 4) and len(names) == array.shape[2]:
            self._set(array, names)
        else:
            self._set(array, [])
        self._is_encoded = array.dtype.kind in "iu"
        self._is_premultiplied = array.dtype.kind == "f"

    def width(self):
        return self._array.shape[1]

    def height(self):
        return self._array.shape[0]

    def size(self):
        """Returns the width and height."""
        return np.array([self.width(), self.height()])

    def channel_count(self):
        return self._array.shape[2]

    def channel_names(self):
        """Returns the names of the channels."""
        return list(self._names)

    def pixel_count(self):
        return self.width() * self.height()

    def pixel_format(self):
        return self._format

    def component_format(self):
        return Struct.Type(self._array.dtype.name)

    def has_alpha(self):
        return "A" in self._format.value

    def bytes_per_pixel(self):
        return self._array.itemsize * self.channel_count()

    def buffer_size(self):
        """Returns the size of the pixels in bytes."""
        return self._array.nbytes

    def srgb_gamma(self):
        """Returns True if colours are encoded in sRGB."""
        return self._is_encoded

    def set_srgb_gamma(self, value):
        """Sets the encoding without changing the pixels."""
        self._is_encoded = bool(value)

    def premultiplied_alpha(self):
        """Returns True if colours are multiplied by alpha."""
        return self._is_premultiplied

    def set_premultiplied_alpha(self, value):
        """Sets this property without changing the pixels."""
        self._is_premultiplied = bool(value)

    def metadata(self):
        """Returns the dict of the file's attributes."""
        return self._metadata

    def clear(self):
        """Sets all pixels to 0."""
        self._array[:] = 0

    def vflip(self):
        """Reverses the order of the rows."""
        self._array = np.ascontiguousarray(self._array[::-1])

    def __array__(self, dtype=None, copy=None):
        array = self._array[..., 0] if self.channel_count() == 1 else self._array
        return array.astype(dtype or array.dtype, copy=copy is not False)

    def __eq__(self, other):
        if not isinstance(other, Bitmap):
            return NotImplemented
        return (self._format, self._names, self._is_encoded, self._array.dtype) == (
            other._format, other._names, other._is_encoded, other._array.dtype) and (
            np.array_equal(self._array, other._array))

    __hash__ = None

    def __repr__(self):
        rows = [("pixel_format", self._format.name), ("component_format", self._array.dtype.name),
                ("size", self.size().tolist()), ("srgb_gamma", self._is_encoded)]
        if self.has_alpha():
            rows.append(("premultiplied_alpha", self._is_premultiplied))
        if self._format is PixelFormat.MultiChannel:
            rows.append(("channels", self._names))
        if self._metadata:
            rows.append(("metadata", self._metadata))
        return "Bitmap[\n" + "".join(f"  {name} = {value},\n" for name, value in rows) + "]"

    def _like(self, array):
        """Returns a bitmap with other pixels and the same properties."""
        other = Bitmap.__new__(Bitmap)
        other.__dict__.update(self.__dict__, _array=array, _names=list(self._names),
                              _metadata=dict(self._metadata))
        return other

    def convert(self, pixel_format=None, component_format=None, srgb_gamma=None,
                alpha_transform=AlphaTransform.Empty):
        """Returns the image in another pixel format, component format, encoding, or with colours
        multiplied or divided by alpha. What isn't given stays as it is. Integers are scaled: the
        largest one is 1."""
        pixel_format = pixel_format or self._format
        check.instance(pixel_format, "pixel_format", PixelFormat, "a PixelFormat")
        kind = check.instance(component_format or self.component_format(), "component_format",
                              Struct.Type, "a Struct.Type")
        srgb_gamma = self._is_encoded if srgb_gamma is None else srgb_gamma
        values = _color.scaled(self._array)
        alpha = self._names.index("A") if "A" in self._names else None
        colors = [c for c in range(self.channel_count()) if c != alpha]
        if self._is_encoded:
            values[..., colors] = _color.srgb_to_linear(values[..., colors])
        is_premultiplied = self._is_premultiplied
        if alpha is not None and alpha_transform is not AlphaTransform.Empty:
            is_premultiplied = alpha_transform is AlphaTransform.Premultiply
            if is_premultiplied != self._is_premultiplied:
                opacity = values[..., [alpha]]
                factor = opacity if is_premultiplied else np.divide(
                    1, opacity, where=opacity > 0, out=np.ones_like(opacity))
                values[..., colors] *= factor
        names = self._names
        if pixel_format is not self._format:
            values = _color.in_format(values, self._names, self._format, pixel_format)
            names = list(pixel_format.value) or names
        if srgb_gamma:
            colors = [c for c, name in enumerate(names) if name != "A"]
            values[..., colors] = _color.linear_to_srgb(values[..., colors])
        other = self._like(_color.unscaled(values, np.dtype(kind.value)))
        other._names, other._format = list(names), pixel_format
        other._is_encoded, other._is_premultiplied = bool(srgb_gamma), is_premultiplied
        return other

    def resample(self, res, rfilter=None):
        """Returns the image with the size `res`, (width, height). rfilter: a reconstruction filter, as
        an object, a dict or a name; by default lanczos with two lobes. Pixels outside of the image are
        those of its edge."""
        size = np.asarray(res)
        if size.shape != (2,):
            raise check.fault(TypeError, "res", "a width and a height", res)
        width, height = (check.whole(one, "res", 1, 2 ** 16) for one in size.tolist())
        if rfilter is None:
            rfilter = {"type": "lanczos", "lobes": 2}
        if isinstance(rfilter, str):
            rfilter = {"type": rfilter}
        if isinstance(rfilter, dict):
            rfilter = load_object(rfilter, [])
        if getattr(rfilter, "category", None) != "rfilter":
            raise check.fault(TypeError, "rfilter", "a reconstruction filter", rfilter)
        radius, table = rfilter._editor.filter(rfilter._path, _FILTER_VALUES)
        result = np.asarray(_color.scaled(self._array), np.float32)
        for axis, count in ((1, width), (0, height)):
            result = _color.resampled(result, axis, count, np.asarray(table), radius)
        return self._like(_color.unscaled(result, self._array.dtype))

    def split(self):
        """Returns pairs of a name and a bitmap, one for each layer: "<root>" for the colour, and the
        prefixes of the other channels' names."""
        layers = {}
        for c, name in enumerate(self._names):
            layer, _, channel = name.rpartition(".")
            layers.setdefault(layer or "<root>", []).append((c, channel))
        bitmaps = []
        for layer, channels in layers.items():
            part = Bitmap(self._array[..., [c for c, _ in channels]],
                          channel_names=[name for _, name in channels])
            part._is_encoded, part._is_premultiplied = self._is_encoded, self._is_premultiplied
            bitmaps.append((layer, part))
        return bitmaps

    def write(self, path, quality=-1):
        """Writes a file in the format of its extension: .exr, .pfm, .hdr, .png, .jpg, .bmp, .tga,
        .tif, and others of OpenImageIO. Converts to sRGB bytes for the formats that store only these,
        and to linear floats for those that store floats. quality: from 1 to 100, for .jpg."""
        path = check.path(path, "path")
        extension = os.path.splitext(path)[1].lower()
        if quality != -1:
            check.whole(quality, "quality", 1, 100)
        image = self._for_file(extension)
        array, names = np.ascontiguousarray(image._array), image._names
        if extension == ".pfm":
            _kinome.write_picture(path, array, names, {})
            return
        has_mattes = any(name.startswith("Crypto") for name in names)
        attributes = {key: value for key, value in self._metadata.items()
                      if isinstance(value, str) and ":" not in key and
                      (has_mattes or not key.startswith("cryptomatte/"))}
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "image" + extension)
            try:
                _images().write(file, array, names, max(quality, 0), attributes)
            except RuntimeError as reason:
                message = str(reason).replace(file, path)
                raise Error(f"{path}: {message}", message, path, 0, 0) from None
            with open(file, "rb") as made:
                _kinome.write_bytes(path, made.read())

    def write_async(self, path, quality=-1):
        """Writes a file as write() does, before it returns."""
        self.write(path, quality)

    def _for_file(self, extension):
        """Returns the image in a form that the file format can store."""
        is_float = self._array.dtype.kind == "f"
        kind = self.component_format()
        if extension == ".exr":
            fits = kind in (Struct.Type.Float16, Struct.Type.Float32, Struct.Type.UInt32)
            return self.convert(None, None if fits else Struct.Type.Float32, False)
        if extension in (".pfm", ".hdr", ".rgbe"):
            image = self._only_color()
            is_grey = extension == ".pfm" and image._format in (PixelFormat.Y, PixelFormat.YA)
            return image.convert(PixelFormat.Y if is_grey else PixelFormat.RGB,
                                 Struct.Type.Float32, False)
        if extension in _LINEAR:
            return self if is_float or kind.value.startswith("uint") else self.convert(
                None, Struct.Type.Float32, False)
        fits = kind is Struct.Type.UInt8 or (kind is Struct.Type.UInt16 and extension == ".png")
        image = self._only_color()
        has_alpha = image.has_alpha() and extension not in _WITHOUT_ALPHA
        # Several other formats don't support images of one channel.
        is_grey = extension in _GREY or image._format in (PixelFormat.Y, PixelFormat.YA) and (
            extension in _WITHOUT_ALPHA + (".png", ".tga"))
        # These formats store colours that aren't multiplied by alpha. Bytes are written as they are,
        # as in Mitsuba.
        unpremultiplies = has_alpha and not fits and self._is_premultiplied
        return image.convert(PixelFormat[("Y" if is_grey else "RGB") + "A" * has_alpha],
                             None if fits else Struct.Type.UInt8, self._is_encoded or not fits,
                             AlphaTransform.Unpremultiply if unpremultiplies
                             else AlphaTransform.Empty)

    def _only_color(self):
        """Returns the colour and alpha of an image with several layers."""
        if self._format is not PixelFormat.MultiChannel:
            return self
        for wanted in (PixelFormat.RGBA, PixelFormat.RGB, PixelFormat.YA, PixelFormat.Y):
            if set(wanted.value) <= set(self._names):
                image = self._like(self._array[..., [self._names.index(c) for c in wanted.value]])
                image._names, image._format = list(wanted.value), wanted
                return image
        raise ValueError(f"there is no colour among the channels {', '.join(self._names)}")

    def _repr_png_(self):
        """Returns the bytes of a PNG file, which notebooks show. None if there is no colour."""
        try:
            color = self._only_color()
        except ValueError:
            return None
        grey = color._format in (PixelFormat.Y, PixelFormat.YA)
        wanted = PixelFormat[("Y" if grey else "RGB") + "A" * color.has_alpha()]
        is_straight = color.has_alpha() and not color._is_premultiplied
        image = color.convert(wanted, Struct.Type.Float32, False, AlphaTransform.Premultiply
                              if is_straight else AlphaTransform.Empty)
        return _kinome.encode_picture(np.ascontiguousarray(image._array), image._names)
