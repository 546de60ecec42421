#!/usr/bin/env python3
"""Exports a scene from Blender to an XML file that Kinome and Mitsuba 3 read.

    blender -b scene.blend --python apps/blender/export.py -- scene.xml
    python apps/blender/export.py scene.blend scene.xml          (in a Python with bpy)

In Blender's text editor, 'Run Script' exports the open scene beside the .blend file.
"""
import argparse
import os
import sys


def package_folder():
    """Returns the folder of the package kinome_export. __file__ of a text in Blender's editor is the
    .blend file with the text's name appended."""
    try:
        import bpy
        text = getattr(bpy.context, "space_data", None)
        text = getattr(text, "text", None)
        if text is not None and text.filepath:
            return os.path.dirname(bpy.path.abspath(text.filepath))
    except ImportError:
        pass
    return os.path.dirname(os.path.abspath(__file__))


def arguments(values, in_blender):
    parser = argparse.ArgumentParser(
        prog="export.py", description="Exports a scene from Blender to an XML file for Kinome and Mitsuba 3.")
    if not in_blender:
        parser.add_argument("blend", help="Blender's file")
    parser.add_argument("xml", help="the file to write; meshes/ and textures/ are written beside it")
    parser.add_argument("--integrator", help="default of the variable integrator: path, or volpath "
                                               "if lamps may shine through masks or area lights")
    parser.add_argument("--sky-width", type=int, default=1024, metavar="PIXELS",
                        help="width of the image that a sky texture becomes: 1024")
    return parser.parse_args(values)


def chosen_scene(bpy):
    """Returns the arguments. Opens Blender's file if this runs in a Python with bpy."""
    if not bpy.app.binary_path:
        options = arguments(sys.argv[1:], in_blender=False)
        if not os.path.isfile(options.blend):
            raise RuntimeError(f"{options.blend}: no such file")
        bpy.ops.wm.open_mainfile(filepath=os.path.abspath(options.blend))
        return options
    if "--" in sys.argv:
        return arguments(sys.argv[sys.argv.index("--") + 1:], in_blender=True)
    if bpy.app.background:
        return arguments([], in_blender=True)
    if not bpy.data.filepath:
        raise RuntimeError("save the scene first: it is exported beside its .blend file")
    return arguments([os.path.splitext(bpy.data.filepath)[0] + ".xml"], in_blender=True)


def main():
    try:
        import bpy
    except ImportError:
        arguments(sys.argv[1:], in_blender=False)  # prints the help, or reports unknown arguments
        sys.exit("export.py: bpy not found: run this in Blender, or in a Python with `pip install bpy`")
    sys.path.insert(0, package_folder())
    from kinome_export.blender_scene import export
    try:
        options = chosen_scene(bpy)
        report = export(options.xml, options.integrator, options.sky_width)
    except (RuntimeError, OSError) as problem:
        sys.exit(f"export.py: {str(problem).strip()}")
    count = len(report.lines)
    print(f"kinome export: wrote {options.xml}, {count} warning{'' if count == 1 else 's'}")


if __name__ == "__main__":
    main()
