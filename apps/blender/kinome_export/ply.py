"""Writes meshes as binary PLY files."""
import os

import numpy as np


def merge_corners(points, corner_points, columns):
    """Returns vertices and the index of each corner's vertex. Corners with the same point and the same
    values share a vertex. `points` has a row per point, `columns` a row per corner."""
    table = np.column_stack([np.asarray(points, np.float32)[corner_points], np.asarray(columns, np.float32)])
    table = np.ascontiguousarray(table + np.float32(0))  # -0 becomes 0
    keys = table.view(np.dtype((np.void, table.dtype.itemsize * table.shape[1]))).ravel()
    _, first, index = np.unique(keys, return_index=True, return_inverse=True)
    return table[first], index.ravel()


def write(path, points, corner_points, normals, uvs=None, colors=None, reversed_faces=False):
    """Writes triangles; three successive corners form one. `points` has a row per point,
    `corner_points` an index per corner, and the others a row per corner. v counts downwards in the file."""
    parts, names = [normals], ["x", "y", "z", "nx", "ny", "nz"]
    if uvs is not None:
        parts.append(np.column_stack([uvs[:, 0], 1 - uvs[:, 1]]))
        names += ["u", "v"]
    if colors is not None:
        parts.append(colors)
        names += ["r", "g", "b"]
    vertices, index = merge_corners(points, corner_points, np.column_stack(parts))
    triangles = index.reshape(-1, 3)
    if reversed_faces:
        triangles = triangles[:, ::-1]
    faces = np.empty(len(triangles), np.dtype([("count", "u1"), ("index", "<i4", 3)]))
    faces["count"], faces["index"] = 3, triangles
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}",
              *(f"property float {name}" for name in names), f"element face {len(faces)}",
              "property list uchar int vertex_indices", "end_header"]
    temporary = f"{path}.part"
    with open(temporary, "wb") as file:
        file.write(("\n".join(header) + "\n").encode())
        file.write(vertices.astype("<f4").tobytes())
        file.write(faces.tobytes())
    os.replace(temporary, path)
