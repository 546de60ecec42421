"""The assets of the car scene: body parts (PLY), wheels (PLY, and the same as GLB), lamps (OBJ)
and the maps of the paint and the rims.
"""

import numpy as np

from . import car_body, files, meshing, stone
from .noise import smooth_noise

UV_AXIS_Y = 0.45


def body_uv(positions):
    """Returns u along the car, v from the underside (0) to the middle of the roof (1)."""
    x, y, z = positions.T
    return np.stack([(x + 2.25) / 4.5, np.arctan2(y - UV_AXIS_Y, np.abs(z)) / np.pi + 0.5], axis=1)


def tyre():
    """Returns a surface of revolution about y, with the axle at the origin."""
    profile = [(0.175, -0.085), (0.200, -0.092)]
    profile += stone.arc((0.262, -0.052), 0.046, 230, 330, 8)
    profile += [(0.311, -0.045), (0.313, 0.0), (0.311, 0.045)]
    profile += stone.arc((0.262, 0.052), 0.046, 30, 130, 8)
    profile += [(0.200, 0.092), (0.175, 0.085)]
    return stone.lathe(profile, 96)


def rim():
    """Returns a dished hub cap with a pressed ring; its outside faces +y."""
    profile = [(0.205, 0.070), (0.203, 0.088), (0.192, 0.093), (0.182, 0.088), (0.176, 0.060)]
    profile += [(0.150, 0.048), (0.118, 0.052)] + stone.arc((0.0, -0.02), 0.115, 40, 90, 14)
    return stone.lathe(profile, 96)


def turned(mesh, side):
    """Turns the axle from y to side * z."""
    def turn(v):
        return np.stack([v[:, 0], -side * v[:, 2], side * v[:, 1]], axis=1)
    return {**mesh, "positions": turn(mesh["positions"]), "normals": turn(mesh["normals"])}


def wheels(folder, name, mesh):
    """Writes four wheels: as one PLY, and as a GLB of two meshes under four nodes."""
    sides = {"left": turned(mesh, 1.0), "right": turned(mesh, -1.0)}
    nodes = [(key, (x, car_body.WHEEL_Y, sign * car_body.WHEEL_Z), (1.0, 1.0, 1.0))
             for x in car_body.WHEEL_X for key, sign in (("left", 1.0), ("right", -1.0))]
    files.write_glb(folder / f"{name}.glb", sides, nodes)
    parts = [{**sides[key], "positions": sides[key]["positions"] + np.array(t)}
             for key, t, _ in nodes]
    whole = merged(parts)
    files.write_ply(folder / f"{name}.ply", whole)
    return len(whole["faces"])


def merged(parts):
    starts = np.cumsum([0] + [len(p["positions"]) for p in parts[:-1]])
    joined = {k: np.concatenate([p[k] for p in parts]) for k in ("positions", "normals", "uv")}
    joined["faces"] = np.concatenate([p["faces"] + s for p, s in zip(parts, starts)])
    return joined


def lamps():
    """Returns two headlamp lenses: domes that face forwards."""
    angles = np.linspace(0.0, np.pi / 2, 15)
    dome = stone.lathe([(0.095 * np.cos(a), 0.052 * np.sin(a)) for a in angles], 64)
    dome = {**dome, "faces": dome["faces"][:, ::-1]}  # exchanging x and y reverses the orientation
    parts = []
    for side in (1.0, -1.0):
        x, y, z = car_body.LAMP_AT
        p, n = dome["positions"], dome["normals"]
        parts.append({**dome, "positions": np.stack([p[:, 1] + x - 0.01, p[:, 0] + y,
                                                     p[:, 2] + side * z], axis=1),
                      "normals": np.stack([n[:, 1], n[:, 0], n[:, 2]], axis=1)})
    return merged(parts)


def seams(height, width):
    """Returns the depth of the gaps around doors, bonnet and boot lid over (v, u): 1 in a gap."""
    u = (np.arange(width) + 0.5)[None, :] / width * 4.5 - 2.25
    v = (np.arange(height) + 0.5)[:, None] / height

    def outline(x0, x1, v0, v1, radius):
        qx = np.abs(u - 0.5 * (x0 + x1)) - 0.5 * (x1 - x0) + radius
        qv = (np.abs(v - 0.5 * (v0 + v1)) - 0.5 * (v1 - v0)) * 2.6 + radius
        edge = np.hypot(np.maximum(qx, 0), np.maximum(qv, 0)) + np.minimum(np.maximum(qx, qv), 0)
        return np.exp(-((edge - radius) / 0.0055) ** 2)

    door = outline(-0.46, 0.62, 0.435, 0.785, 0.05)
    bonnet = outline(0.86, 1.86, 0.665, 1.40, 0.06)
    boot = outline(-2.02, -1.55, 0.670, 1.40, 0.06)
    return np.maximum(door, np.maximum(bonnet, boot))


def normal_map(height, width):
    """Returns normals of panel gaps and slight orange peel: x along u, y along v, z outwards."""
    relief = -1.1 * seams(height, width) + 0.030 * smooth_noise(height, width, (160, 320), 7)
    du = 0.5 * (np.roll(relief, -1, axis=1) - np.roll(relief, 1, axis=1))
    dv = 0.5 * (np.roll(relief, -1, axis=0) - np.roll(relief, 1, axis=0))
    n = np.stack([-du, -dv, np.ones_like(du)], axis=2)
    n /= np.linalg.norm(n, axis=2)[:, :, None]
    return 0.5 * n + 0.5


def specular_map(height, width):
    """Returns the reflectance of the clear coat: road film low on the sides, dark in the gaps."""
    v = (np.arange(height) + 0.5)[:, None] / height
    film = (0.6 * smooth_noise(height, width, (24, 96), 3)
            + 0.4 * smooth_noise(height, width, (96, 384), 5))
    dirt = np.clip((0.50 + 0.16 * (film - 0.5) - v) / 0.14, 0.0, 1.0)
    return (1.0 - 0.75 * dirt * (0.6 + 0.4 * film)) * (1.0 - 0.9 * seams(height, width))


def brushed_map(size):
    """Returns the roughness of the rims (raw): rings as from a lathe; v is along the profile."""
    v = smooth_noise(size, size, (64, 4), 11)
    return 0.06 + 0.14 * v


def make(folder, scale):
    """Writes the files. Returns the number of triangles."""
    def axes(spacing, bounds):
        s = spacing * scale
        return [meshing.graded_axis(low, high, lambda _: s) for low, high in bounds]

    extent = [(-2.5, 2.4), (0.0, 1.45), (-1.02, 1.021)]
    count = 0
    for name, field, spacing in (("body", car_body.body, 0.021), ("glass", car_body.glass, 0.0135),
                                 ("chrome", car_body.chrome, 0.0125),
                                 ("tail", car_body.tail_lamps, 0.0125)):
        mesh = meshing.mesh_field(field, axes(spacing, extent))
        if name == "body":
            mesh["uv"] = body_uv(mesh["positions"])
        files.write_ply(folder / f"{name}.ply", mesh)
        count += len(mesh["faces"])
    count += wheels(folder, "tyres", tyre()) + wheels(folder, "rims", rim())
    lenses = lamps()
    files.write_obj(folder / "lamps.obj", lenses)
    files.write_png(folder / "paint_normal.png", normal_map(1024, 2048))
    coat = specular_map(512, 1024)
    files.write_png(folder / "paint_specular.png", coat)
    files.write_png(folder / "paint_gloss.png", 0.15 * coat)  # for models without Fresnel
    files.write_png(folder / "rim_alpha.png", brushed_map(256))
    return count + len(lenses["faces"])
