"""Converts a camera, given as a dictionary, to a sensor."""
import math

from . import elements as e
from .matrices import TURN_Y, scaling, without_scale


def field_of_view(camera, width, height):
    """Returns the axis that Blender's field of view spans, and its angle in degrees."""
    fit = camera["sensor_fit"]
    axis = ("x" if width >= height else "y") if fit == "AUTO" else {"HORIZONTAL": "x", "VERTICAL": "y"}[fit]
    size = camera["sensor_height"] if fit == "VERTICAL" else camera["sensor_width"]
    return axis, math.degrees(2 * math.atan(size / (2 * camera["lens"])))


def film_element(film):
    """`film` has width, height, filter (BOX, GAUSSIAN or BLACKMAN_HARRIS) and filter_width [pixels]."""
    if film["filter"] == "BOX":
        rfilter = e.plugin("rfilter", "box")
    else:
        # Cycles' Gaussian is exp(-72 x^2 / width^2). The standard deviation of its Blackman-Harris
        # window is 0.135 of the width.
        share = 1 / 12 if film["filter"] == "GAUSSIAN" else 0.135
        rfilter = e.plugin("rfilter", "gaussian", e.floating("stddev", share * film["filter_width"]))
    return e.plugin("film", "hdrfilm", e.parameter("integer", "width", "$resx"),
                    e.parameter("integer", "height", "$resy"), e.string("pixel_format", "rgb"), rfilter)


def sensor(camera, film, report):
    """`camera` has Blender's parameters: type, matrix (to the world), lens and sensor sizes [mm],
    shift_x and shift_y, clip_start and clip_end, and `dof` (None, or fstop and distance)."""
    owner = f"camera '{camera['name']}'"
    width, height = film["width"], film["height"]
    to_world = without_scale(camera["matrix"]) @ TURN_Y
    children = [e.floating("near_clip", camera["clip_start"]), e.floating("far_clip", camera["clip_end"])]
    dof = camera.get("dof")
    kind = "thinlens" if dof else "perspective"
    larger = max(width, height)
    if camera["type"] == "PERSP":
        axis, angle = field_of_view(camera, width, height)
        children += [e.string("fov_axis", axis), e.floating("fov", angle)]
        if camera["shift_x"] or camera["shift_y"]:
            fitted = width if axis == "x" else height
            if dof:
                report.warn(owner, "depth of field is left out, because a thin lens can't be shifted")
                kind = "perspective"
            children += [e.floating("principal_point_offset_x", camera["shift_x"] * fitted / width),
                         e.floating("principal_point_offset_y", -camera["shift_y"] * fitted / height)]
        if kind == "thinlens":
            children += [e.floating("aperture_radius", 1e-3 * camera["lens"] / (2 * dof["fstop"])),
                         e.floating("focus_distance", dof["distance"])]
            if dof.get("blades", 0) > 0:
                report.warn(owner, "the aperture is a disk instead of a polygon")
    elif camera["type"] == "ORTHO":
        kind = "orthographic"
        half = camera["ortho_scale"] / 2 * (width / larger)
        to_world = to_world @ scaling(half, half, 1)
        if camera["shift_x"] or camera["shift_y"]:
            report.warn(owner, "the shift of an orthographic camera is left out")
    else:
        report.warn(owner, "panoramic cameras are unsupported; exported with a field of view of 90 degrees")
        kind = "perspective"
        children += [e.floating("fov", 90)]
    sampler = e.plugin("sampler", "independent", e.parameter("integer", "sample_count", "$spp"))
    return e.plugin("sensor", kind, *children, e.transform("to_world", to_world), sampler, film_element(film))
