"""Writers: PLY, OBJ, GLB meshes, PNG and PFM images, XML. The same input gives the same bytes."""

import json
import struct
import zlib

import numpy as np


def write_ply(path, mesh):
    """Writes a binary little-endian PLY with normals, and with u and v if the mesh has them."""
    columns = ["x", "y", "z", "nx", "ny", "nz"]
    data = [mesh["positions"], mesh["normals"]]
    if "uv" in mesh:
        columns += ["u", "v"]
        data.append(mesh["uv"])
    vertices = np.concatenate(data, axis=1).astype("<f4")
    faces = np.zeros(len(mesh["faces"]), dtype=[("n", "u1"), ("i", "<i4", 3)])
    faces["n"] = 3
    faces["i"] = mesh["faces"]
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    header += [f"property float {c}" for c in columns]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    with open(path, "wb") as out:
        out.write(("\n".join(header) + "\n").encode("ascii"))
        out.write(vertices.tobytes())
        out.write(faces.tobytes())


def write_plys(folder, meshes):
    """Writes a PLY for each named mesh. Returns the total number of triangles."""
    for name, mesh in meshes.items():
        write_ply(folder / f"{name}.ply", mesh)
    return sum(len(mesh["faces"]) for mesh in meshes.values())


def scene_xml(elements):
    """Returns the text of a file for <include> from the texts of its elements."""
    return '<scene version="3.0.0">\n' + "\n".join(elements) + "\n</scene>\n"


def write_obj(path, mesh):
    """Writes an OBJ file with texture coordinates (v upwards, as in OBJ) and normals."""
    lines = ["v %.7g %.7g %.7g" % tuple(p) for p in mesh["positions"]]
    lines += ["vt %.7g %.7g" % (u, 1.0 - v) for u, v in mesh["uv"]]
    lines += ["vn %.6g %.6g %.6g" % tuple(n) for n in mesh["normals"]]
    lines += ["f " + " ".join(f"{i}/{i}/{i}" for i in face + 1) for face in mesh["faces"]]
    with open(path, "w", encoding="ascii", newline="\n") as out:
        out.write("\n".join(lines) + "\n")


def write_glb(path, meshes, nodes):
    """Writes binary glTF 2.0: meshes by name; nodes are triples (mesh name, translation, scale)."""
    names = sorted(meshes)
    blob, views, accessors, entries = b"", [], [], []

    def add(array, target, kind, component, bounds):
        nonlocal blob
        views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": array.nbytes,
                      "target": target})
        entry = {"bufferView": len(views) - 1, "componentType": component,
                 "count": array.size if kind == "SCALAR" else len(array), "type": kind}
        if bounds:
            entry["min"] = [float(v) for v in array.min(axis=0)]
            entry["max"] = [float(v) for v in array.max(axis=0)]
        accessors.append(entry)
        blob += array.tobytes() + b"\0" * (-array.nbytes % 4)
        return len(accessors) - 1

    for name in names:
        mesh = meshes[name]
        attributes = {
            "POSITION": add(np.asarray(mesh["positions"], "<f4"), 34962, "VEC3", 5126, True),
            "NORMAL": add(np.asarray(mesh["normals"], "<f4"), 34962, "VEC3", 5126, False)}
        if "uv" in mesh:
            attributes["TEXCOORD_0"] = add(np.asarray(mesh["uv"], "<f4"), 34962, "VEC2", 5126,
                                           False)
        indices = add(np.asarray(mesh["faces"], "<u4").ravel(), 34963, "SCALAR", 5125, False)
        entries.append({"name": name, "primitives": [
            {"attributes": attributes, "indices": indices}]})
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": [{"mesh": names.index(n), "translation": list(t), "scale": list(s)}
                  for n, t, s in nodes],
        "meshes": entries, "accessors": accessors, "bufferViews": views,
        "buffers": [{"byteLength": len(blob)}]}
    text = json.dumps(document, separators=(",", ":")).encode("ascii")
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as out:
        out.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(blob)))
        out.write(struct.pack("<I4s", len(text), b"JSON") + text)
        out.write(struct.pack("<I4s", len(blob), b"BIN\0") + blob)


def write_png(path, image):
    """Writes an 8-bit PNG from an (h, w) or (h, w, 3) array of values in [0, 1]."""
    pixels = np.clip(np.floor(np.asarray(image) * 255.0 + 0.5), 0, 255).astype(np.uint8)
    height, width = pixels.shape[:2]
    rows = pixels.reshape(height, -1)
    raw = np.concatenate([np.zeros((height, 1), np.uint8), rows], axis=1).tobytes()

    def chunk(kind, data):
        return (struct.pack(">I", len(data)) + kind + data
                + struct.pack(">I", zlib.crc32(kind + data)))

    header = struct.pack(">IIBBBBB", width, height, 8, 0 if pixels.ndim == 2 else 2, 0, 0, 0)
    with open(path, "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header)
                  + chunk(b"IDAT", zlib.compress(raw, 6)) + chunk(b"IEND", b""))


def write_pfm(path, image):
    """Writes a little-endian portable float map from an (h, w, 3) array, with rows from the bottom."""
    height, width = image.shape[:2]
    with open(path, "wb") as out:
        out.write(f"PF\n{width} {height}\n-1.0\n".encode("ascii"))
        out.write(np.asarray(image[::-1], "<f4").tobytes())


def write_vol(path, values):
    """Writes a grid of voxels in Mitsuba's format from a (z, y, x) array of numbers, in the unit cube."""
    z, y, x = values.shape
    with open(path, "wb") as out:
        out.write(b"VOL\x03" + struct.pack("<5i6f", 1, x, y, z, 1, 0, 0, 0, 1, 1, 1))
        out.write(np.ascontiguousarray(values, "<f4").tobytes())
