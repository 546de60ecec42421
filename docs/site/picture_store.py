"""Keeps the images of plugins between builds of the site. An image is rendered again only if the contents of
one of its dependencies have changed: its scene, the files that scenes name, the program, or a plugin that the
render loads.
"""
import hashlib
import json
import shutil

import plugin_pictures


def digest(*parts):
    whole = hashlib.sha256()
    for part in parts:
        whole.update(hashlib.sha256(part).digest())
    return whole.hexdigest()


class PictureStore:
    def __init__(self, build, folder):
        """`folder` is for the images and the files that scenes name."""
        self.build = build
        self.program = build / "bin/kinome"
        self.folder = folder
        self.rendered = 0  # number of images that weren't in the store
        self.known = {}  # digests of files
        plugin_pictures.make_files(folder / "files")
        fixed = [self.program, *(build / "lib").glob("libkinome.so"), *(build / "plugins/support").glob("*.so"),
                 *(folder / "files").glob("*.*")]
        self.fixed = self.digest_of(path for path in fixed if path.suffix != ".xml")

    def digest_of(self, paths):
        for path in (paths := sorted(paths)):
            if path not in self.known:
                self.known[path] = digest(path.name.encode(), path.read_bytes())
        return digest(*(self.known[path].encode() for path in paths))

    def key(self, scene, exposure, plugins):
        """Returns the hash of an image's dependencies. plugins: ["bsdf/diffuse", ...]. A plugin may have several
        libraries, one per instruction set."""
        libraries = [path for name in plugins
                     for path in (self.build / "plugins").glob(f"{name}*.so")]
        return digest(scene.encode(), str(exposure).encode(), self.fixed.encode(),
                      self.digest_of(libraries).encode())

    def put(self, category, name, example, target):
        """Writes the image to `target`. Returns False if the plugin has no image."""
        scene = plugin_pictures.scene_of(category, name, example)
        if scene is None:
            return False
        exposure = plugin_pictures.EXPOSURE.get(name, 0)
        picture = self.folder / f"{category}-{name}.png"
        entry = picture.with_suffix(".json")
        if not (picture.exists() and entry.exists() and self.is_current(entry, scene, exposure)):
            entry.unlink(missing_ok=True)
            plugins = plugin_pictures.render(self.program, self.folder / "files", category, name, scene,
                                             exposure, picture)
            entry.write_text(json.dumps({"plugins": plugins, "key": self.key(scene, exposure, plugins)}),
                             "utf-8")
            self.rendered += 1
        shutil.copy(picture, target)
        return True

    def is_current(self, entry, scene, exposure):
        stored = json.loads(entry.read_text("utf-8"))
        return stored["key"] == self.key(scene, exposure, stored["plugins"])
