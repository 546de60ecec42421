"""The assets of the hebe scene: the statue (PLY) and its plinth (OBJ)."""

from . import files, meshing, statue_dress, stone


def statue(scale):
    """Returns the closed mesh: 160,000 triangles at scale 1."""
    mesh = meshing.mesh_field(statue_dress.figure, statue_dress.axes(scale))
    if not meshing.is_watertight(mesh["faces"]):
        raise RuntimeError("the statue isn't watertight")
    return mesh


def make(folder, scale):
    """Writes the files. Returns the number of triangles."""
    figure, pedestal = statue(scale), stone.plinth()
    files.write_ply(folder / "statue.ply", figure)
    files.write_obj(folder / "plinth.obj", pedestal)
    return len(figure["faces"]) + len(pedestal["faces"])
