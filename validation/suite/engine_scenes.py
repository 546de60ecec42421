"""Copies of scenes as the benchmark of the engine needs them: they find their files from wherever
they lie, for both programs."""
import re

from .kinome import with_parameters


def with_filenames(text, folder):
    """A scene's text whose files are named from `folder`."""
    text = re.sub(r'(<string name="filename" value=")', rf"\g<1>{folder}/", text)
    return re.sub(r'(<include filename=")(?=\.)', rf"\g<1>{folder}/", text)


def with_size(path, folder):
    """A small scene has a size and an integrator of its own: the copy takes them by -D."""
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
