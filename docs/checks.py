"""Writes docs/checks.md: the output of `kinome check` for a new plugin, and for plugins with planted
faults.

    ninja -C build kinome_renderer tests_check
    python3 docs/checks.py [BUILD]

BUILD: the build folder; default: build. Takes some ten seconds, most of them for the new plugin's build.
"""
import html
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/check"))
from wrong_plugins import WRONG_PLUGINS, library  # noqa: E402

PAGE = ROOT / "docs/checks.md"
TITLES = {"emitter": "Emitters", "lamp": "Area emitters", "bsdf": "BSDFs", "shape": "Shapes", "texture": "Textures",
          "volume": "Volumes", "phase": "Phase functions", "medium": "Media",
          "sampler": "Samplers", "sensor": "Sensors", "rfilter": "Filters"}
SUBJECTS = {"emitter": "A constant sky",
            "lamp": "A diffuse area light", "sensor": "A pinhole camera", "bsdf": "A white diffuse surface",
            "shape": "A square", "texture": "A ramp from 0 to 1", "volume": "A ramp from 0 to 1",
            "phase": "Isotropic scattering", "medium": "A ramp of the extinction from 0 to 1", "sampler": "Independent random numbers",
            "rfilter": "A tent"}

BEGIN = """# Faults that `kinome check` finds

<!-- Written by docs/checks.py, which explains how. -->

[`kinome check`](writing-plugins.md#checking-a-plugin) tests whether the functions of a plugin meet their
contract. For example, it tests whether samples follow their density, and whether a block of points has the
values of single points. This page shows its output for a correct plugin, and for {count} plugins with one fault
each. All of it is real output, except that `~` stands for the path of the folder.

## A new plugin

These commands run in the folder of a clone after a build that includes the tests' plugins
(`ninja -C build tests_check`):

"""

WRONG = """
The first test of `ctest` runs `kinome check`. This is what it prints:

"""

FAULT = """
## A faulty plugin

This sky is sampled uniformly, and its functions return half the density of its samples. A renderer divides by
the density, so the light of this sky would be twice as bright. The check `sampling` names the fault. The
other failing checks compare the same density with other functions.

"""

TABLES = """
The exit status is 1, so `ctest` fails.

## All faults that the tests plant

Each of these plugins is correct except for the fault that its parameter `fault` selects, such as
`-D 'fault=half density'`. Their sources are {sources}.
A test runs each plugin. It fails if the check in the table doesn't name the fault, or if it finds a fault in
the plugin without `fault`. Other checks may fail, too. The numbers are of one run.
"""


class Shell:
    """Runs commands in a folder, and returns them with their output."""

    def __init__(self, folder):
        self.folder = folder

    def run(self, command, status=0):
        done = subprocess.run(["sh", "-c", command], cwd=self.folder, text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, check=False)
        if done.returncode != status:
            sys.exit(f"{command}: exit status {done.returncode}\n{done.stdout}")
        return f"$ {command}\n{done.stdout}".replace(str(self.folder), "~")

    def block(self, *commands, status=0):
        return "```text\n" + "".join(self.run(command, status) for command in commands) + "```\n"


def transcript(build):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name).resolve()
        (folder / "build").symlink_to(build)
        shell = Shell(folder)
        begun = shell.block(
            "cmake --install build --prefix kinome-sdk >install.log",
            "kinome-sdk/bin/kinome new emitter my_sky",
            "cmake -S my_sky -B my_sky/build -DCMAKE_PREFIX_PATH=$PWD/kinome-sdk",
            "cmake --build my_sky/build",
            "ctest --test-dir my_sky/build")
        right = shell.block("kinome-sdk/bin/kinome check my_sky/build/plugins/emitter/my_sky.so")
        wrong = shell.block("kinome-sdk/bin/kinome check build/tests/check/plugins/emitter/wrong.so "
                            "-D 'fault=half density'", status=1)
    return begun + WRONG + right + FAULT + wrong


def sentence_of(build, source, fault, check):
    command = [str(build / "bin/kinome"), "check",
               str(build / "tests/check/plugins" / library(source)), "-D", f"fault={fault}",
               "--only", check]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    found = re.search(f"^  FAULT {check} +(.*)$", done.stdout, re.MULTILINE)
    if not found:
        sys.exit(f"{shlex.join(command)}: names no fault\n{done.stdout}{done.stderr}")
    return found.group(1)


def cell(text):
    """Escapes the text of a table cell, so that neither Markdown nor HTML interprets it."""
    return re.sub(r"([\\|*_`\[\]])", r"\\\1", html.escape(text, quote=False))


def uncell(text):
    return html.unescape(re.sub(r"\\(.)", r"\1", text))


def tables(build):
    text = ""
    for source, rows in WRONG_PLUGINS.items():
        text += (f"\n### {TITLES[source]}\n\n{SUBJECTS[source]}.\n\n"
                 "| `fault` | meaning | check | output |\n|---|---|---|---|\n")
        for fault, wrong, check, _ in rows:
            printed = cell(sentence_of(build, source, fault, check))
            text += f"| {fault} | {wrong} | `{check}` | {printed} |\n"
    return text


def rows_of(page):
    """Returns (source, fault, meaning, check, output) of each row of the page's tables."""
    rows = []
    sources = {title: source for source, title in TITLES.items()}
    for part in re.split("^### ", page, flags=re.MULTILINE)[1:]:
        source = sources[part.partition("\n")[0]]
        for line in re.findall(r"^\| (.*) \|$", part, re.MULTILINE)[1:]:
            fault, wrong, check, printed = line.split(" | ")
            rows.append((source, fault, wrong, check.strip("`"), uncell(printed)))
    return rows


def main():
    build = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else
                         os.environ.get("KINOME_BUILD", ROOT / "build")).resolve()
    sources = ", ".join(f"[wrong_{source}.cpp](../tests/check/wrong_{source}.cpp)"
                        for source in WRONG_PLUGINS)
    count = sum(len(rows) for rows in WRONG_PLUGINS.values())
    page = (BEGIN.format(count=count) + transcript(build) + TABLES.format(sources=sources)
            + tables(build))
    PAGE.write_text(page, "utf-8")
    print(f"wrote {PAGE}")


if __name__ == "__main__":
    main()
