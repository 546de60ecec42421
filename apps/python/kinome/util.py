"""Helpers with the names of mitsuba.util."""
from ._bitmap import Bitmap, Struct
from ._scene import render, traverse
from ._transform import Transform

__all__ = ["convert_to_bitmap", "cornell_box", "render", "traverse", "write_bitmap"]


def convert_to_bitmap(data, uint8_srgb=True):
    """Converts an array or a render to a Bitmap: in bytes, encoded in sRGB, or else in linear floats.
    """
    bitmap = data if isinstance(data, Bitmap) else Bitmap(data)
    if uint8_srgb:
        return bitmap._only_color().convert(component_format=Struct.Type.UInt8, srgb_gamma=True)
    return bitmap.convert(component_format=Struct.Type.Float32, srgb_gamma=False)


def write_bitmap(filename, data, write_async=True, quality=-1):
    """Writes an array, a render or a Bitmap to a file in the format of its extension, such as .png or
    .exr. The file is complete when the function returns; write_async has no effect. quality: from 1 to
    100, for .jpg."""
    bitmap = data if isinstance(data, Bitmap) else Bitmap(data)
    bitmap.write(filename, quality)


def _matte(*reflectance):
    return {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(reflectance)}}


def _placed(plugin, bsdf, to_world):
    return {"type": plugin, "to_world": to_world, "bsdf": {"type": "ref", "id": bsdf}}


def cornell_box():
    """Returns the dict of a Cornell box for load_dict(), with the keys and values of Mitsuba's
    function of this name, except for focus_distance, which has no effect. The room is [-1, 1]^3 and
    open toward the camera."""
    place = Transform()
    light = _placed("rectangle", "white", place.translate([0, 0.99, 0.01]).rotate([1, 0, 0], 90)
                    .scale([0.23, 0.19, 0.19]))
    light["emitter"] = {"type": "area",
                        "radiance": {"type": "rgb", "value": [18.387, 13.9873, 6.75357]}}
    walls = {
        "floor": ("white", [0, -1, 0], [1, 0, 0], -90),
        "ceiling": ("white", [0, 1, 0], [1, 0, 0], 90),
        "back": ("white", [0, 0, -1], [0, 1, 0], 0),
        "green-wall": ("green", [1, 0, 0], [0, 1, 0], -90),
        "red-wall": ("red", [-1, 0, 0], [0, 1, 0], 90),
    }
    boxes = {
        "small-box": ([0.335, -0.7, 0.38], -17, 0.3),
        "large-box": ([-0.33, -0.4, -0.28], 18.25, [0.3, 0.61, 0.3]),
    }
    return {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 8},
        "sensor": {
            "type": "perspective",
            "fov_axis": "smaller",
            "near_clip": 0.001,
            "far_clip": 100.0,
            "fov": 39.3077,
            "to_world": place.look_at(origin=[0, 0, 3.9], target=[0, 0, 0], up=[0, 1, 0]),
            "sampler": {"type": "independent", "sample_count": 64},
            "film": {"type": "hdrfilm", "width": 256, "height": 256, "pixel_format": "rgb",
                     "component_format": "float32", "rfilter": {"type": "gaussian"}},
        },
        "white": _matte(0.885809, 0.698859, 0.666422),
        "green": _matte(0.105421, 0.37798, 0.076425),
        "red": _matte(0.570068, 0.0430135, 0.0443706),
        "light": light,
        **{name: _placed("rectangle", bsdf, place.translate(at).rotate(axis, angle))
           for name, (bsdf, at, axis, angle) in walls.items()},
        **{name: _placed("cube", "white", place.translate(at).rotate([0, 1, 0], angle).scale(size))
           for name, (at, angle, size) in boxes.items()},
    }
