"""Folders for meshes and textures beside the scene file."""
import hashlib
import os
import shutil

from .elements import Names

_READABLE = (".png", ".jpg", ".jpeg", ".exr", ".hdr", ".tga", ".bmp")


class Files:
    """Stores files below the folder of a scene and returns names relative to it."""

    def __init__(self, folder):
        self.folder = folder
        self._names = {"meshes": Names(), "textures": Names()}
        self._images, self._baked = {}, {}

    def path(self, kind, name, suffix):
        """Returns a new file's path and its name in the scene. `kind` is 'meshes' or 'textures'."""
        os.makedirs(os.path.join(self.folder, kind), exist_ok=True)
        relative = f"{kind}/{self._names[kind].unique(name)}{suffix}"
        return os.path.join(self.folder, relative), relative

    def image(self, node):
        """Stores the image of a node, once, and returns its name. `node["image"]` is Blender's image."""
        image = node["image"]
        key = image.name_full  # with the library of a linked image
        if key not in self._images:
            self._images[key] = self._store(image)
        return self._images[key]

    def pixels(self, node):
        """Returns the linear texels of a node's image: rows from top to bottom, four channels."""
        import numpy as np
        image = node["image"]
        width, height = image.size
        values = np.empty(width * height * image.channels, np.float32)
        image.pixels.foreach_get(values)
        values = values.reshape(height, width, image.channels)[::-1].astype(float)
        if image.channels < 4:
            color = values[..., :3] if image.channels == 3 else np.repeat(values[..., :1], 3, -1)
            values = np.concatenate([color, np.ones((height, width, 1))], -1)
        if not image.is_float and not node["is_data"]:
            color = values[..., :3]
            values[..., :3] = np.where(color <= 0.04045, color / 12.92, ((color + 0.055) / 1.055) ** 2.4)
        return values

    def baked(self, name, texels, is_exact=False):
        """Stores linear texels, rows of colours from top to bottom, and returns the file's name. Equal
        texels share a file. Unless `is_exact`, values in [0, 1] are stored with 8 bits in sRGB."""
        content = hashlib.sha256(repr(texels.shape).encode() + texels.tobytes()).digest()
        if content not in self._baked:
            in_range = 0 <= texels.min() and texels.max() <= 1
            self._baked[content] = self._bake(name, texels, is_float=is_exact or not in_range)
        return self._baked[content]

    def _bake(self, name, texels, is_float):
        import bpy
        import numpy as np
        path, relative = self.path("textures", name, ".exr" if is_float else ".png")
        height, width = texels.shape[:2]
        image = bpy.data.images.new("kinome export", width, height, float_buffer=is_float, is_data=is_float)
        try:
            rgba = np.ones((height, width, 4), np.float32)
            color = texels[::-1]
            rgba[..., :3] = color if is_float else \
                np.where(color <= 0.0031308, 12.92 * color, 1.055 * np.maximum(color, 0) ** (1 / 2.4) - 0.055)
            image.pixels.foreach_set(rgba.ravel())
            image.file_format = "OPEN_EXR" if is_float else "PNG"
            image.save(filepath=path)
        finally:
            bpy.data.images.remove(image)
        return relative

    def _store(self, image):
        import bpy
        stem, suffix = os.path.splitext(os.path.basename(image.filepath) or image.name)
        if suffix.lower() in _READABLE and image.source == "FILE" and not image.is_dirty:
            path, relative = self.path("textures", stem, suffix.lower())
            if image.packed_file:
                with open(path, "wb") as file:
                    file.write(image.packed_file.data)
            else:
                shutil.copyfile(bpy.path.abspath(image.filepath, library=image.library), path)
            return relative
        # Generated images, and formats that Mitsuba doesn't read.
        path, relative = self.path("textures", stem or image.name, ".exr" if image.is_float else ".png")
        copy = image.copy()
        try:
            copy.file_format = "OPEN_EXR" if image.is_float else "PNG"
            copy.save(filepath=path)
        finally:
            bpy.data.images.remove(copy)
        return relative
