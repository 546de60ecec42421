"""Exports Blender's current scene."""
import os

import bpy
import numpy as np

from . import camera, elements as e, lights, materials, world
from .blender_meshes import Triangles, render_visibility
from .blender_nodes import has, surface_of
from .files import Files
from .report import Report
from .textures import as_color, as_number, fold, is_link, nodes_below

_SURFACES = ("MESH", "CURVE", "SURFACE", "FONT", "META")
# Instances cost time per ray. They are used if they save at least so many triangles.
_MIN_SAVED_TRIANGLES = 10000


def export(path, integrator=None, sky_width=1024, report=None):
    """Writes the current scene to an XML file, with `meshes` and `textures` beside it. Returns the
    report of warnings. The integrator is `path` or `volpath` if it is None. `sky_width` is the width of
    worlds that are baked to images [pixels]."""
    return _Export(bpy.context.scene, path, sky_width, report or Report()).run(integrator)


class _Export:
    def __init__(self, scene, path, sky_width, report):
        self.scene, self.path, self.sky_width, self.report = scene, os.path.abspath(path), sky_width, report
        self.files = Files(os.path.dirname(self.path))
        self.ids = e.Names()
        self.bsdfs, self.emitters, self.shapes = [], [], []
        self.materials = {}  # name -> id, Material, colour attribute

    def run(self, integrator):
        if self.scene.camera is None:
            raise RuntimeError("the scene has no camera: set one in the scene's properties")
        layer = bpy.context.view_layer
        with render_visibility(self.scene, layer):
            graph = bpy.context.evaluated_depsgraph_get()
            self._add_objects(graph)
            film = self._film()
            sensor = camera.sensor(self._camera(self.scene.camera.evaluated_get(graph)), film, self.report)
        sky = self._world()
        root = e.ET.Element("scene", {"version": "3.0.0"})
        for name, value in (("integrator", integrator or self._integrator()), ("spp", self.scene.cycles.samples),
                            ("max_depth", self.scene.cycles.max_bounces + 1),
                            ("resx", film["width"]), ("resy", film["height"])):
            e.ET.SubElement(root, "default", {"name": name, "value": str(value)})
        root.append(e.plugin("integrator", "$integrator", e.parameter("integer", "max_depth", "$max_depth")))
        root.append(sensor)
        root.extend([sky] if sky is not None else [])
        root.extend(self.emitters + self.bsdfs + self.shapes)
        e.write(root, self.path)
        return self.report

    def _integrator(self):
        """Returns `volpath` if light of lamps may pass through invisible surfaces, which `path` takes for
        obstacles: masks and the shapes of area lights."""
        invisible = any(b.get("type") in ("null", "mask") for top in self.bsdfs + self.shapes for b in top.iter("bsdf"))
        return "volpath" if self.emitters and invisible else "path"

    def _film(self):
        render, cycles = self.scene.render, self.scene.cycles
        if abs(render.pixel_aspect_x / render.pixel_aspect_y - 1) > 1e-3:
            self.report.warn("scene", "pixels are square in the exported scene")
        if abs(cycles.film_exposure - 1) > 1e-3:
            self.report.warn("scene", "the film's exposure is left out")
        share = render.resolution_percentage / 100
        return {"width": int(render.resolution_x * share), "height": int(render.resolution_y * share),
                "filter": cycles.pixel_filter_type, "filter_width": cycles.filter_width}

    def _camera(self, thing):
        data = thing.data
        dof = None
        if data.dof.use_dof and data.type == "PERSP":
            distance = data.dof.focus_distance
            if data.dof.focus_object:
                to_focus = data.dof.focus_object.matrix_world.translation - thing.matrix_world.translation
                distance = -to_focus.dot(thing.matrix_world.to_3x3().col[2].normalized())
            dof = {"fstop": data.dof.aperture_fstop, "distance": distance, "blades": data.dof.aperture_blades}
        names = ("type", "sensor_fit", "sensor_width", "sensor_height", "lens", "shift_x", "shift_y",
                 "clip_start", "clip_end", "ortho_scale")
        return {**{name: getattr(data, name) for name in names}, "name": thing.name, "dof": dof,
                "matrix": np.array(thing.matrix_world)}

    def _add_objects(self, graph):
        uses, order = {}, []
        for instance in graph.object_instances:
            thing = instance.object
            if thing.original.hide_render or not instance.show_self:
                continue
            matrix = np.array(instance.matrix_world)
            if thing.type == "LIGHT":
                self._add_light(thing, matrix)
            elif thing.type in _SURFACES:
                self._check_object(thing)
                slots = [slot.material.name if slot.material else None for slot in thing.material_slots]
                key = (thing.data.as_pointer(), *slots)
                if key not in uses:
                    uses[key] = []
                    # The object of an instance is only valid during the loop.
                    order.append((key, thing.name, slots or [None], Triangles(thing, self.report)))
                uses[key].append(matrix)
            elif thing.type in ("CURVES", "VOLUME", "POINTCLOUD"):
                self.report.warn(f"object '{thing.name}'", f"objects of type {thing.type} are left out")
        for key, name, slots, triangles in order:
            self._add_mesh(name, slots, triangles, uses[key])

    def _check_object(self, thing):
        if any(system.settings.type == "HAIR" and system.settings.render_type == "PATH"
               for system in thing.particle_systems):
            self.report.warn(f"object '{thing.name}'", "hair is left out")
        visible = (thing.visible_camera, thing.visible_diffuse, thing.visible_glossy,
                   thing.visible_transmission, thing.visible_shadow)
        if not all(visible):
            self.report.warn(f"object '{thing.name}'", "its ray visibility is ignored; all rays see it")

    def _add_mesh(self, name, slots, triangles, matrices):
        parts = []  # of a slot each: label, id of the BSDF, Material, function from mirrored to the file
        for slot in triangles.used_slots():
            material_name = slots[min(slot, len(slots) - 1)]
            id, material, color = self._material(material_name)
            label = name if len(triangles.used_slots()) == 1 else f"{name}-{material_name or 'default'}"
            parts.append((label, id, material, self._mesh_writer(triangles, slot, color, label)))
        saved = (len(matrices) - 1) * len(triangles.slots)
        grouped = [p for p in parts if p[2].radiance is None] if saved >= _MIN_SAVED_TRIANGLES else []
        for part in parts:
            if part not in grouped:
                # A negative determinant turns the outside of a mesh, but not of an instance.
                self.shapes += [self._ply(part, np.linalg.det(m[:3, :3]) < 0, m) for m in matrices]
        if grouped:
            group = self.ids.unique(f"group-{name}")
            self.shapes.append(e.plugin("shape", "shapegroup", *(self._ply(p, False, None) for p in grouped), id=group))
            self.shapes += [e.plugin("shape", "instance", e.reference(group), e.transform("to_world", m))
                            for m in matrices]

    def _mesh_writer(self, triangles, slot, color, label):
        written = {}

        def file(is_mirrored):
            if is_mirrored not in written:
                path, written[is_mirrored] = self.files.path("meshes", label, ".ply")
                triangles.write(path, slot, color, is_mirrored)
            return written[is_mirrored]
        return file

    def _ply(self, part, is_mirrored, matrix):
        label, bsdf, material, file = part
        emitter = None if material.radiance is None else e.plugin("emitter", "area", material.radiance)
        return e.plugin("shape", "ply", e.string("filename", file(is_mirrored)),
                        None if matrix is None else e.transform("to_world", matrix),
                        e.reference(bsdf), emitter, id=self.ids.unique(f"mesh-{label}"))

    def _material(self, name):
        if name not in self.materials:
            node, attribute = self._nodes_of_material(name)
            result = materials.material(name or "default", node, self.files, self.report, self.ids)
            id = self.ids.unique(f"mat-{name or 'default'}")
            result.bsdf.attrib = {"type": result.bsdf.get("type"), "id": id}
            self.bsdfs.append(result.bsdf)
            self.materials[name] = id, result, attribute
        return self.materials[name]

    def _nodes_of_material(self, name):
        default = {"type": "BSDF_DIFFUSE", "name": "default", "inputs": {"Color": [0.8] * 3, "Roughness": 0.0}}
        if name is None:
            return default, None
        material = bpy.data.materials[name]
        if not material.use_nodes:
            default["inputs"]["Color"] = list(material.diffuse_color)[:3]
            return default, None
        for target in ("Volume", "Displacement"):
            if has(material.node_tree, target):
                self.report.warn(f"material '{name}'", f"'{target}' is left out")
        node = surface_of(material.node_tree)
        return node, _attribute(node) if node else None

    def _add_light(self, thing, matrix):
        data = thing.data
        owner = f"light '{thing.name}'"
        color, energy = list(data.color), data.energy * 2.0 ** getattr(data, "exposure", 0)
        if getattr(data, "use_temperature", False):
            color = [c * t for c, t in zip(color, data.temperature_color)]
        node = surface_of(data.node_tree) if data.use_nodes and data.node_tree else None
        if node is not None:
            values = [fold(node["inputs"].get(name, 1.0)) for name in ("Color", "Strength")]
            if node["type"] != "EMISSION" or any(is_link(v) for v in values):
                self.report.warn(owner, "its nodes are ignored, because they aren't a constant Emission")
            else:
                color = [c * x for c, x in zip(color, as_color(values[0]))]
                energy *= as_number(values[1])
        if not (data.use_shadow and data.cycles.max_bounces > 0):
            self.report.warn(owner, "it casts shadows and takes part in all bounces in the exported scene")
        light = {"type": data.type, "name": thing.name, "matrix": matrix, "color": color, "energy": energy,
                 "normalize": getattr(data, "normalize", True)}
        for ours, theirs in (("radius", "shadow_soft_size"), ("spot_size", "spot_size"), ("angle", "angle"),
                             ("spot_blend", "spot_blend"), ("shape", "shape"), ("size", "size"),
                             ("size_y", "size_y"), ("spread", "spread")):
            if hasattr(data, theirs):
                light[ours] = getattr(data, theirs)
        element = lights.light(light, self.files, self.report)
        if element is not None:
            element.set("id", self.ids.unique(f"light-{thing.name}"))
            (self.shapes if element.tag == "shape" else self.emitters).append(element)

    def _world(self):
        data = self.scene.world
        if data is None:
            return None
        if not data.use_nodes:
            radiance = list(data.color)
            return e.plugin("emitter", "constant", e.rgb("radiance", radiance)) if any(radiance) else None
        if has(data.node_tree, "Volume"):
            self.report.warn(f"world '{data.name}'", "'Volume' is left out")
        return world.world(data.name, surface_of(data.node_tree), self.files, self.report, self._bake_world)

    def _bake_world(self):
        """Renders the world alone to a latitude-longitude image whose centre is in direction +x."""
        path, relative = self.files.path("textures", "world", ".exr")
        scene = bpy.data.scenes.new("kinome export: world")
        data = bpy.data.cameras.new(scene.name)
        thing = bpy.data.objects.new(scene.name, data)
        try:
            scene.world = self.scene.world
            data.type, data.panorama_type = "PANO", "EQUIRECTANGULAR"
            thing.rotation_euler = (np.pi / 2, 0, -np.pi / 2)
            scene.collection.objects.link(thing)
            scene.camera = thing
            _set_up_bake(scene, self.sky_width, path)
            bpy.ops.render.render(write_still=True, scene=scene.name)
        finally:
            bpy.data.objects.remove(thing)
            bpy.data.cameras.remove(data)
            bpy.data.scenes.remove(scene)
        return relative


def _set_up_bake(scene, width, path):
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, width // 2, 100
    render.filepath, render.use_file_extension = path, False
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    render.image_settings.color_mode = "RGB"
    scene.view_settings.view_transform = "Raw"
    cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = 64, False, False
    cycles.pixel_filter_type = "BOX"
    cycles.filter_width = 1
    cycles.sample_clamp_direct = 0


def _attribute(node):
    """Returns the name of the first colour attribute that a node reads; None if it reads none."""
    for one in nodes_below(node):
        if one["type"] in ("VERTEX_COLOR", "ATTRIBUTE") and one["is_color"]:
            return one["attribute"]
    return None
