"""Collects the pages of the site from the repository, and creates a page for each plugin.

    collect.py BUILD FOLDER

BUILD is the build folder with the program and its plugins. The script writes these files:

  - FOLDER/pictures: images of plugins, which the next build reuses;
  - FOLDER/pages: every Markdown file under its path in the repository, with the linked images and data.
    For a linked source file, a page with its text; for a linked folder, a page with a list of its files;
  - FOLDER/mkdocs.yml: docs/mkdocs.yml with the pages of the plugins.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys

from links import CODE, LINK, pages
from picture_store import PictureStore
from plugin_sources import ROOT, example, sources

STATIC = {".png", ".jpg", ".csv", ".json", ".html", ".css", ".svg", ".ipynb", ".mp4"}
LANGUAGES = {".h": "cpp", ".cpp": "cpp", ".inc": "cpp", ".py": "python", ".sh": "sh", ".xml": "xml",
             ".txt": "cmake", ".cmake": "cmake"}
TITLES = {"bsdf": "BSDFs", "emitter": "Emitters", "film": "Films", "integrator": "Integrators",
          "medium": "Media", "phase": "Phase functions", "volume": "Volumes",
          "rfilter": "Filters", "sampler": "Samplers", "sensor": "Sensors", "shape": "Shapes",
          "texture": "Textures and spectra"}


def source_page(path):
    """Returns a page with the text of a file, or with the list of a folder's files."""
    name = path.relative_to(ROOT)
    if path.is_dir():
        files = sorted(p.relative_to(path) for p in path.rglob("*")
                       if p.is_file() and "__pycache__" not in p.parts)
        return f"# {name}/\n\n" + "".join(f"- `{file}`\n" for file in files[:400])
    text = path.read_text("utf-8")
    fence = "`" * max(3, *(len(run) + 1 for run in re.findall("`+", text) or [""]))
    return f"# {path.name}\n\n`{name}`\n\n{fence}{LANGUAGES.get(path.suffix, '')}\n{text}{fence}\n"


class Collection:
    def __init__(self, folder):
        self.folder = folder
        self.shown = {}  # pages of linked files, by file
        self.known = set()

    def put(self, name, text):
        target = self.folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, "utf-8")

    def target_of(self, page, target):
        """Returns the target of a page's link in the site. Copies the linked file to the site."""
        name, hash_mark, anchor = target.partition("#")
        if re.match(r"[a-z]+:", target) or not name:
            return target
        path = (page.parent / name).resolve()
        if path in self.known or not path.exists():
            return target  # another page, or a dead link, which MkDocs reports
        inside = path.relative_to(ROOT)
        if path.is_file() and path.suffix in STATIC:
            (self.folder / inside).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, self.folder / inside)
            return target
        if path.is_dir() and path / "README.md" in self.known:
            return name.rstrip("/") + "/README.md" + hash_mark + anchor
        shown = "source" / inside.with_name(inside.name + ".md")
        if path not in self.shown:
            self.shown[path] = shown
            self.put(shown, source_page(path))
        return os.path.relpath(self.folder / shown, (self.folder / page.relative_to(ROOT)).parent)

    def add(self, page):
        text = page.read_text("utf-8")
        code = [m.span() for m in CODE.finditer(text)]

        def replaced(match):
            if any(begin <= match.start() < end for begin, end in code):
                return match.group(0)
            whole, target = match.group(0), match.group(1)
            return whole[:-len(target) - 1] + self.target_of(page, target) + ")"

        self.put(page.relative_to(ROOT), LINK.sub(replaced, text))

    def add_all(self):
        self.known = set(pages(ROOT))
        for page in self.known:
            self.add(page)


def registered(program):
    """Yields (category, name) of each plugin that the program finds."""
    listed = subprocess.run([program, "plugins"], capture_output=True, text=True, check=True).stdout
    category = None
    for line in listed.splitlines():
        if line and not line.startswith(" "):
            category = line
        elif re.match(r"  \S", line):
            yield category, line.split()[0]


def plugin_page(store, folder, category, name, source):
    text = subprocess.run([store.program, "plugins", "--markdown", f"{category}/{name}"], capture_output=True,
                          text=True, check=True).stdout
    xml = example(source) if source else None
    title, _, rest = text.partition("\n")
    shown = ""
    if store.put(category, name, xml, folder / f"{name}.png"):
        shown = f"\n![{name}]({name}.png)\n"
    if xml:
        rest += f"\n```xml\n{xml}\n```\n"
    (folder / f"{name}.md").write_text(f"{title}\n{shown}{rest}", "utf-8")


def linked_overview(text):
    """Returns the text of docs/plugins.md in which the plugins' names in the table link to their pages, which
    exist only in the site."""
    def row(match):
        category, names, rest = match.groups()
        return f"| {category} | " + re.sub(
            r"`(\w+)`", lambda name: f"[{name[0]}](reference/{category}/{name[1]}.md)", names) + f" | {rest}"

    return re.sub(r"^\| (\w+) \| ((?:`\w+`(?:, )?)+) \| (.*)", row, text, flags=re.MULTILINE)


def plugin_pages(build, folder, pages_folder):
    """Writes the pages of all plugins. Returns their lines of the navigation."""
    store = PictureStore(build, folder / "pictures")
    found = list(registered(store.program))
    where = sources()
    for category, name in found:
        target = pages_folder / "docs/reference" / category
        target.mkdir(parents=True, exist_ok=True)
        plugin_page(store, target, category, name, where.get((category, name)))
    print(f"rendered {store.rendered} images of plugins")
    overview = pages_folder / "docs/plugins.md"
    overview.write_text(linked_overview(overview.read_text("utf-8")), "utf-8")
    lines = []
    for category in dict.fromkeys(category for category, _ in found):
        lines.append(f"      - {TITLES.get(category, category)}:")
        lines += [f'          - "{name}": docs/reference/{category}/{name}.md'
                  for c, name in found if c == category]
    return "\n".join(lines)


def main():
    build, folder = (pathlib.Path(argument).resolve() for argument in sys.argv[1:])
    pages_folder = folder / "pages"
    shutil.rmtree(pages_folder, ignore_errors=True)
    collection = Collection(pages_folder)
    collection.add_all()
    for name in ("docs/site/extra.css", "docs/site/iframe-worker.js"):
        collection.put(name, (ROOT / name).read_text("utf-8"))
    lines = plugin_pages(build, folder, pages_folder)
    configuration = (ROOT / "docs/mkdocs.yml").read_text("utf-8")
    (folder / "mkdocs.yml").write_text(configuration.replace("      - PLUGIN PAGES", lines), "utf-8")


if __name__ == "__main__":
    main()
