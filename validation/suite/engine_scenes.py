"""Copies of scenes for the benchmark of the engine. Both programs find the files of a copy, wherever it
is."""
import re

from .kinome import with_parameters
from .problems import Problem

WATERTIGHT = "watertight"  # parameter of a copy: "true" or "false"

def with_filenames(text, folder):
    """Returns a scene's text with `folder` in front of its file names."""
    text = re.sub(r'(<string name="filename" value=")', rf"\g<1>{folder}/", text)
    return re.sub(r'(<include filename=")(?=\.)', rf"\g<1>{folder}/", text)


def like_for_like(path, folder, is_small):
    """Writes a copy of a scene for which both programs trace rays by Embree in the same way: not in its robust
    mode, unless -D sets it. Off is Mitsuba's default, but not ours. A small scene has a fixed size and
    integrator, which become parameters of the copy."""
    if is_small:
        copy = with_size(path, folder)
        text = copy.read_text(encoding="utf-8")
    else:
        # Scenes in different folders have the same file name.
        copy = folder / f"{path.parent.name}-{path.name}"
        folder.mkdir(parents=True, exist_ok=True)
        text = path.read_text(encoding="utf-8")
    head = (f'<path value="{path.parent}"/> <default name="{WATERTIGHT}" value="false"/> '
            f'<boolean name="embree_use_robust_intersections" value="${WATERTIGHT}"/>')
    text, count = re.subn(r"(<scene [^>]*>)", rf"\1 {head}", text, count=1)
    if count != 1:
        raise Problem(f"{path.name}: has no <scene>")
    copy.write_text(text, encoding="utf-8")
    return copy


def with_size(path, folder):
    copy = with_parameters(path, folder)
    text = copy.read_text(encoding="utf-8")
    for name in ("width", "height"):
        text = re.sub(rf'<integer name="{name}" value="\d+"/>',
                      f'<integer name="{name}" value="${name}"/>', text)
    text = re.sub(r'(<film type="hdrfilm">)',
                  r'\1 <string name="file_format" value="$file_format"/>', text)
    text = re.sub(r"(<scene [^>]*>)", r'\1 <default name="file_format" value="openexr"/>', text,
                  count=1)
    copy.write_text(with_filenames(text, path.parent), encoding="utf-8")
    return copy
