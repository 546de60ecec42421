#!/usr/bin/python3
"""Tests of light groups: their layers add up to the image, and each has the light of its emitters
alone.

KINOME_BUILD is the build folder. With KINOME_PACKAGE, the installed module is tested.
"""
import copy
import os
import pathlib
import sys
import tempfile
import unittest

import numpy as np

BUILD = pathlib.Path(os.environ["KINOME_BUILD"]).resolve()
if "KINOME_PACKAGE" not in os.environ:
    sys.path.insert(0, str(BUILD / "python"))
import kinome  # noqa: E402

T = kinome.Transform
LIGHTS = {
    "sky": {"type": "constant", "radiance": {"type": "rgb", "value": [0.3, 0.5, 0.9]}},
    "ball": {"type": "sphere", "radius": 0.4, "center": [-1.5, 1, 0],
             "emitter": {"type": "area", "radiance": {"type": "rgb", "value": [4, 3, 1]}}},
    "frame": {"type": "rectangle", "to_world": T().translate([0, 3, 0]).rotate([1, 0, 0], 90),
              "panel": {"type": "area", "id": "panel",
                        "radiance": {"type": "rgb", "value": [2, 5, 3]}}},
    "lamp": {"type": "point", "position": [2, 1, 1],
             "intensity": {"type": "rgb", "value": [6, 2, 2]}},
    "sun": {"type": "directional", "direction": [1, -2, -1],
            "irradiance": {"type": "rgb", "value": [1, 0.8, 0.5]}},
}
SCENE = {
    "type": "scene",
    "sensor": {
        "type": "perspective",
        "to_world": T().look_at([0, 1.5, 6], [0, 1, 0], [0, 1, 0]),
        "sampler": {"type": "independent", "sample_count": 4},
        "film": {"type": "hdrfilm", "width": 24, "height": 18, "pixel_format": "rgba",
                 "rfilter": {"type": "gaussian"}},
    },
    "floor": {"type": "rectangle", "to_world": T().rotate([1, 0, 0], -90).scale(50)},
    "glossy": {"type": "sphere", "radius": 0.7, "center": [0.5, 0.7, 0],
               "bsdf": {"type": "roughplastic"}},
    "mirror": {"type": "sphere", "radius": 0.4, "center": [-0.6, 0.4, 1],
               "bsdf": {"type": "conductor"}},
    # Emitter samples go through it.
    "pane": {"type": "rectangle", "to_world": T().translate([0.5, 1, 4]).scale(0.4),
             "bsdf": {"type": "thindielectric"}},
}
PATH = {"type": "path"}
# Product sampling. Short renders would be left to `path`.
PRODUCT = {"type": "clustered", "trial": False}


def scene(groups="all", nested=PATH, **more):
    integrator = {"type": "aov", "light_groups": groups, "image": nested}
    return kinome.load_dict({**copy.deepcopy(SCENE), "integrator": integrator, **LIGHTS, **more})


def groups_of(picture):
    return [name[7:-2] for name in picture.channels
            if name.startswith("lights.") and name.endswith(".R")]


class LightGroups(unittest.TestCase):
    def check_sum(self, picture, *groups):
        self.assertEqual(groups_of(picture), list(groups))
        layers = [picture["lights." + group].astype(float) for group in groups]
        rounding = 3e-6 * sum(np.abs(layer) for layer in layers) + 1e-9
        self.assertLess(np.max(np.abs(sum(layers) - picture.rgb) / rounding), 1)
        self.assertGreater(min(layer.max() for layer in layers), 0.01)

    def test_layers_add_up_to_the_image(self):
        for nested in (PATH, {"type": "path", "max_depth": 2, "hide_emitters": True},
                       {"type": "direct", "emitter_samples": 2, "bsdf_samples": 1},
                       {"type": "volpath"}, {"type": "clustered"}, PRODUCT,
                       {**PRODUCT, "max_depth": 2, "hide_emitters": True, "diagnostics": True}):
            for filtered in ({"rfilter": {"type": "box"}}, {"rfilter": {"type": "mitchell"}},
                             {"crop_offset_x": 5, "crop_width": 11}):
                sensor = copy.deepcopy(SCENE["sensor"])
                sensor["film"].update(filtered)
                grouped = scene("sun: sky sun; lamps: panel,ball", nested, sensor=sensor)
                with self.subTest(nested=nested, filtered=filtered):
                    self.check_sum(kinome.render(grouped), "sun", "lamps", "rest")

    def test_budgets_and_many_samples_add_up(self):
        for nested, options in ((PATH, {"spp": 200}), (PATH, {"time": 0.2}), (PATH, {"variance": 4}),
                                (PRODUCT, {"time": 0.1}), (PRODUCT, {"variance": 4})):
            picture = kinome.render(scene(nested=nested), seed=1, **options)
            self.check_sum(picture, "sky", "lamp", "sun", "ball", "panel")

    def test_response_of_the_sensor_multiplies_groups(self):
        meter = {"type": "irradiancemeter", "film": {"type": "hdrfilm", "width": 2, "height": 2},
                 "sampler": {"type": "independent", "sample_count": 64}}
        target = {"type": "rectangle", "to_world": T().translate([0, 0.2, 0.3]), "meter": meter}
        for nested in (PATH, PRODUCT):
            grouped = scene(nested=nested, target=target)
            sensor = next(s for s in range(len(grouped.sensors())) if s != 0)
            self.check_sum(kinome.render(grouped, sensor=sensor), "sky", "lamp", "sun", "ball", "panel")

    def test_each_layer_is_the_image_of_its_emitters(self):
        """Paths and random numbers don't depend on radiances, so that a layer has the samples of
        the scene in which all other emitters are black."""
        black = {"type": "rgb", "value": [0, 0, 0]}
        for nested in (PATH, {"type": "direct"}, {"type": "volpath"}):
            picture = kinome.render(scene("all", nested), seed=5)
            for lit in groups_of(picture):
                lights = copy.deepcopy(LIGHTS)
                for name, light in lights.items():
                    emitter = {"ball": light.get("emitter"), "frame": light.get("panel")}.get(name, light)
                    if lit in (name, emitter.get("id")):
                        continue
                    quantity = {"lamp": "intensity", "sun": "irradiance"}.get(name, "radiance")
                    emitter[quantity] = black
                alone = kinome.load_dict({**copy.deepcopy(SCENE), "integrator": nested, **lights})
                np.testing.assert_allclose(picture["lights." + lit], kinome.render(alone, seed=5).rgb,
                                           rtol=1e-5, atol=1e-6, err_msg=f"{nested} {lit}")

    def test_image_is_that_without_groups(self):
        picture = kinome.render(scene())
        plain = kinome.render(kinome.load_dict({**copy.deepcopy(SCENE), "integrator": PATH, **LIGHTS}))
        np.testing.assert_allclose(picture.rgb, plain.rgb, rtol=1e-5, atol=1e-7)

    def test_product_sampling_with_groups_has_the_same_samples(self):
        """Without mirrors and panes, because light groups leave out what only paths from lamps find."""
        plain = {name: value for name, value in SCENE.items() if name not in ("mirror", "pane")}
        for filtered in ({"rfilter": {"type": "box"}}, {}):
            ungrouped = copy.deepcopy({**plain, **LIGHTS, "integrator": PRODUCT})
            ungrouped["sensor"]["film"].update(filtered)
            grouped = {**ungrouped, "integrator": {"type": "aov", "light_groups": "a: sky; b: lamp ball",
                                                   "image": PRODUCT}}
            picture = kinome.render(kinome.load_dict(grouped))
            self.check_sum(picture, "a", "b", "rest")
            np.testing.assert_allclose(picture.rgb, kinome.render(kinome.load_dict(ungrouped)).rgb,
                                       rtol=1e-4, atol=1e-5)

    def test_groups_of_product_sampling_have_the_light_of_paths(self):
        """Compares thirds of the image over several renders by Welch's t-test. The layers of `path` are
        the images of their emitters alone. 5 layers of 3 thirds, with t above 7 for at least 11 degrees
        of freedom: normal noise would fail with one in 2,900 sets of seeds."""
        def thirds(nested, spp):
            """Returns means by render, layer and third."""
            means = []
            for seed in range(12):
                picture = kinome.render(scene("all", nested), seed=seed, spp=spp)
                means.append([picture["lights." + name].mean(axis=2).reshape(18, 3, 8).mean(axis=(0, 2))
                              for name in groups_of(picture)])
            return np.asarray(means, float)
        product, paths = thirds(PRODUCT, 16), thirds(PATH, 64)
        errors = np.sqrt((product.var(axis=0, ddof=1) + paths.var(axis=0, ddof=1)) / 12)
        t = (product.mean(axis=0) - paths.mean(axis=0)) / errors
        self.assertLess(np.abs(t).max(), 7, t.round(1))
        # In most of them, the test would notice a sixth of the light in another group.
        self.assertLess(np.median(errors / paths.mean(axis=0)), 1 / 6 / 7)

    def test_other_scenes_are_rendered_by_path_tracing(self):
        """Product sampling supports neither media nor emission alone."""
        fog = {"type": "sphere", "radius": 0.5, "center": [1, 1.5, 1], "bsdf": {"type": "null"},
               "interior": {"type": "homogeneous", "sigma_t": 2.0, "albedo": 0.8}}
        for name, depth, more in (("volpath", -1, {"fog": fog}), ("path", 1, {})):
            pictures = [kinome.render(scene("all", {"type": nested, "max_depth": depth}, **more), seed=2)
                        for nested in ("clustered", name)]
            self.assertEqual(groups_of(pictures[0]), groups_of(pictures[1]))
            for layer in groups_of(pictures[0]):
                np.testing.assert_array_equal(pictures[0]["lights." + layer], pictures[1]["lights." + layer])

    def test_emitters_without_id_are_the_rest(self):
        xml = """<scene version="3.0.0"><integrator type="aov"><string name="light_groups" value="all"/>
            <integrator type="path"/></integrator><emitter type="constant"/>
            <emitter type="point" id="lamp"/><shape type="sphere"><point name="center" value="0,0,3"/></shape>
            </scene>"""
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "scene.xml"
            file.write_text(xml, "utf-8")
            self.check_sum(kinome.render(kinome.load_file(file), spp=1), "lamp", "rest")

    def test_nested_aov_keeps_names(self):
        inner = {"type": "aov", "light_groups": "sun: sky sun", "image": PATH}
        outer = {"type": "aov", "aovs": "d:depth", "inner": inner}
        nested = kinome.load_dict({**copy.deepcopy(SCENE), "integrator": outer, **LIGHTS})
        picture = kinome.render(nested)
        self.check_sum(picture, "sun", "rest")
        self.assertIn("d.T", picture.channels)

    def test_edited_lamps_stay_in_their_groups(self):
        grouped = scene()
        before = kinome.render(grouped)
        parameters = kinome.traverse(grouped)
        parameters["lamp.intensity.value"] = [12, 4, 4]
        parameters.update()
        after = kinome.render(grouped)
        np.testing.assert_allclose(after["lights.lamp"], 2 * before["lights.lamp"], rtol=1e-5)
        np.testing.assert_array_equal(after["lights.sun"], before["lights.sun"])

    def test_edited_lists(self):
        for nested in (PATH, PRODUCT):
            integrator = {"type": "aov", "light_groups": "all", "aovs": "d:depth", "image": nested}
            grouped = scene(integrator=integrator)
            parameters = kinome.traverse(grouped)
            parameters.update({"integrator.light_groups": "a: sky"})
            self.check_sum(kinome.render(grouped), "a", "rest")
            with self.assertRaisesRegex(kinome.Error, "unknown emitter 'sku'"):
                parameters.update({"integrator.light_groups": "b: sku"})
            self.check_sum(kinome.render(grouped), "a", "rest")
            parameters.unset("integrator.light_groups")
            parameters.update()
            picture = kinome.render(grouped)
            self.assertEqual(groups_of(picture), [])
            del integrator["light_groups"]
            np.testing.assert_array_equal(picture, kinome.render(scene(integrator=integrator)))

    def test_wrong_lists_are_refused(self):
        for groups, message in (
                ("a: skie", r"names the unknown emitter 'skie' \(did you mean 'sky'\?\)"),
                ("a: sky; b: sun sky", "names the emitter 'sky' twice"),
                ("a: sky; a: sun", "names the group 'a' twice"),
                ("a.b: sky", r"has the group 'a\.b': a name must not contain"),
                ("sky sun", "must be 'all', or groups such as"),
                (" ; ", "must be 'all', or name at least one group")):
            with self.assertRaisesRegex(kinome.Error, "'light_groups' " + message):
                scene(groups)
        with self.assertRaisesRegex(kinome.Error, "must not use the name 'lights.sky'"):
            scene("sky: sky", integrator={"type": "aov", "light_groups": "sky: sky",
                                          "aovs": "lights.sky:albedo", "image": PATH})
        with self.assertRaisesRegex(kinome.Error, "'integrator/ptracer' renders no light groups"):
            scene(nested={"type": "ptracer"})
        with self.assertRaisesRegex(kinome.Error, "'light_groups' requires importance 'product'"):
            scene(nested={"type": "clustered", "importance": "joint"})
        with self.assertRaisesRegex(kinome.Error, "isn't supported by 'clustered' with max_geometry_term"):
            kinome.render(scene(nested={"type": "clustered", "max_geometry_term": 10}))


if __name__ == "__main__":
    unittest.main()
