"""Reads Blender's evaluated objects: triangles with materials, normals, texture coordinates, colours."""
import contextlib

import numpy as np

from . import ply


@contextlib.contextmanager
def render_visibility(scene, view_layer):
    """Shows what renders show for as long as the context lasts. A script only gets the objects and
    modifiers of the viewport."""
    undo = []

    def set_value(owner, name, value):
        undo.append((owner, name, getattr(owner, name)))
        setattr(owner, name, value)
    for thing in scene.objects:
        if thing.name in view_layer.objects and thing.hide_get(view_layer=view_layer):
            thing.hide_set(False, view_layer=view_layer)
            undo.append((thing, None, view_layer))
        set_value(thing, "hide_viewport", thing.hide_render)
        for modifier in thing.modifiers:
            set_value(modifier, "show_viewport", modifier.show_render)
            if modifier.type in ("SUBSURF", "MULTIRES"):
                set_value(modifier, "levels", modifier.render_levels)
    view_layer.update()
    try:
        yield
    finally:
        for owner, name, value in reversed(undo):
            if name is None:
                owner.hide_set(True, view_layer=value)
            else:
                setattr(owner, name, value)
        view_layer.update()


class Triangles:
    """Triangles of an evaluated object, divided by material slots."""

    def __init__(self, thing, report):
        mesh = thing.to_mesh()
        try:
            self._read(mesh, f"object '{thing.name}'", report)
        finally:
            thing.to_mesh_clear()

    def _read(self, mesh, owner, report):
        mesh.calc_loop_triangles()
        count = len(mesh.loop_triangles)
        self.points = _get(mesh.vertices, "co", 3)
        corners = _get(mesh.loop_triangles, "loops", 3, np.int32).ravel()
        self.corner_points = _get(mesh.loops, "vertex_index", 1, np.int32)[corners]
        self.normals = _get(mesh.corner_normals, "vector", 3)[corners]
        self.slots = _get(mesh.loop_triangles, "material_index", 1, np.int32)
        self.uvs, self.colors = None, {}
        if not count:
            return
        if len(mesh.uv_layers) > 1:
            report.warn(owner, "only the UV map that is active in renders is exported")
        for layer in mesh.uv_layers:
            if layer.active_render:
                self.uvs = _get(layer.uv, "vector", 2)[corners]
        for attribute in mesh.color_attributes:
            values = _get(attribute.data, "color", 4)[:, :3]
            self.colors[attribute.name] = values[corners if attribute.domain == "CORNER" else self.corner_points]
        index = mesh.color_attributes.render_color_index
        self.active_color = mesh.color_attributes[index].name if 0 <= index < len(mesh.color_attributes) else None

    def used_slots(self):
        return sorted(set(self.slots.tolist()))

    def write(self, path, slot, color, reversed_faces):
        """Writes the triangles of a slot. `color` is the name of a colour attribute, '' for the active
        one, or None."""
        chosen = np.repeat(self.slots == slot, 3)
        used, corner_points = np.unique(self.corner_points[chosen], return_inverse=True)
        colors = None
        if color is not None:
            values = self.colors.get(color or self.active_color)
            # As in Cycles, a missing attribute is black.
            colors = np.zeros((len(corner_points), 3)) if values is None else values[chosen]
        ply.write(path, self.points[used], corner_points.ravel(), self.normals[chosen],
                  None if self.uvs is None else self.uvs[chosen], colors, reversed_faces)


def _get(items, name, width, dtype=np.float32):
    values = np.empty(len(items) * width, dtype)
    items.foreach_get(name, values)
    return values.reshape(-1, width) if width > 1 else values
