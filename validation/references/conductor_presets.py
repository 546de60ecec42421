"""Prints the table of Mitsuba's conductors in libs/spectra/include/kinome/measured_indices.h.

    PYTHON validation/references/conductor_presets.py

PYTHON must have the package mitsuba 3.9.1, which integrates the measured indices of refraction to RGB.
"""
import pathlib

import mitsuba as mi

mi.set_variant("scalar_rgb")
mi.set_log_level(mi.LogLevel.Error)


def numbers(values):
    """Formats values with 6 significant digits, as C++ float literals."""
    texts = (f"{float(v):.6g}" for v in values)
    return ", ".join((t if "." in t or "e" in t else t + ".") + "f" for t in texts)


def main():
    folder = pathlib.Path(mi.__file__).parent / "data" / "ior"
    names = {file.name.split(".")[0] for file in folder.glob("*.spd")}
    rows = {}
    for name in sorted(names, key=lambda n: (n.lower(), n)):
        values = mi.traverse(mi.load_dict({"type": "conductor", "material": name}))
        eta, k = (numbers(values[f"{part}.value"]) for part in ("eta", "k"))
        rows[name] = f"{{{eta}}}, {{{k}}}"
    for name, row in rows.items():
        if rows.get(name.removesuffix("_palik")) == row and name.endswith("_palik"):
            continue
        second = f'"{name}_palik"' if rows.get(f"{name}_palik") == row else "nullptr"
        print(f'    {{"{name}", {row}, {second}}},')


if __name__ == "__main__":
    main()
