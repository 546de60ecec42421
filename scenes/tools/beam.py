"""The assets of the beam scene: the room of the room scene, whose window has a cross of bars."""

from . import box, files, room, solids


def make(folder, _scale):
    """Writes the files. Returns the number of triangles."""
    return files.write_plys(folder, {"walls": room.walls(), "furniture": room.furniture(),
                                     "books": room.books(),
                                     "boxes": box.together([
                                         solids.cuboid((-0.2, 0.78, -0.7), (0.15, 1.02, -0.45)),
                                         solids.cuboid((0.3, 0.78, -0.5), (0.5, 0.93, -0.25))])})
