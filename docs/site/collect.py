"""Collects the pages of the site from the repository, and makes those about plugins.

    collect.py BUILD FOLDER

BUILD: the build folder with program and plugins. FOLDER/pictures keeps the pictures of plugins for the
next build. FOLDER/pages gets every Markdown file under its path in
the repository, with the pictures and data that it links; a source file that is linked becomes a page of
its text, a folder one of its files. FOLDER/mkdocs.yml is docs/mkdocs.yml with the plugins' pages.
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
    """A page that shows a file, or lists a folder."""
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
        self.shown = {}  # of files that pages link: their pages' paths
        self.known = set()

    def put(self, name, text):
        target = self.folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, "utf-8")

    def target_of(self, page, target):
        """What a link of a page leads to in the site; the file that it names is brought along."""
        name, hash_mark, anchor = target.partition("#")
        if re.match(r"[a-z]+:", target) or not name:
            return target
        path = (page.parent / name).resolve()
        if path in self.known or not path.exists():
            return target  # another page; a dead link is MkDocs's to complain of
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
    """(category, name) of all plugins that the program finds."""
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
    """The page docs/plugins.md, in whose table each plugin's name links to its page. In the repository, there
    are no such pages."""
    def row(match):
        category, names, rest = match.groups()
        return f"| {category} | " + re.sub(
            r"`(\w+)`", lambda name: f"[{name[0]}](reference/{category}/{name[1]}.md)", names) + f" | {rest}"

    return re.sub(r"^\| (\w+) \| ((?:`\w+`(?:, )?)+) \| (.*)", row, text, flags=re.MULTILINE)


def plugin_pages(build, folder, pages_folder):
    """The lines of the navigation."""
    store = PictureStore(build, folder / "pictures")
    found = list(registered(store.program))
    where = sources()
    for category, name in found:
        target = pages_folder / "docs/reference" / category
        target.mkdir(parents=True, exist_ok=True)
        plugin_page(store, target, category, name, where.get((category, name)))
    print(f"rendered {store.rendered} pictures of plugins")
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
