"""Builds the elements of Mitsuba's scene files."""
import os
import re
import xml.etree.ElementTree as ET


def number(value):
    """Formats a number with the seven digits of a float."""
    return format(float(value), ".7g")


def numbers(values):
    return " ".join(number(v) for v in values)


def plugin(tag, plugin_type, *children, name=None, id=None):
    """Returns an element such as <bsdf type="diffuse">. Children that are None are left out."""
    attributes = {"type": plugin_type}
    if id is not None:
        attributes["id"] = id
    if name is not None:
        attributes["name"] = name
    element = ET.Element(tag, attributes)
    element.extend(child for child in children if child is not None)
    return element


def parameter(tag, name, value):
    return ET.Element(tag, {"name": name, "value": value})


def floating(name, value):
    return parameter("float", name, number(value))


def integer(name, value):
    return parameter("integer", name, str(int(value)))


def boolean(name, value):
    return parameter("boolean", name, "true" if value else "false")


def string(name, value):
    return parameter("string", name, value)


def rgb(name, value):
    return parameter("rgb", name, numbers(value))


def reference(id, name=None):
    return ET.Element("ref", {"id": id} if name is None else {"id": id, "name": name})


def transform(name, matrix):
    """`matrix` has four rows of four numbers."""
    element = ET.Element("transform", {"name": name})
    ET.SubElement(element, "matrix", {"value": numbers(x for row in matrix for x in row)})
    return element


def named(element, name):
    """Returns a copy of an element with another attribute `name`, which comes first."""
    copy = ET.Element(element.tag, {"name": name, **element.attrib, "name": name})
    copy.extend(list(element))
    copy.text = element.text
    return copy


def share_bsdfs(element, unique_id):
    """Replaces each BSDF that occurs again below an element by a reference to the first one, which gets the id
    that unique_id() returns."""
    seen = {}  # by id(), which stays unique while the elements exist

    def visit(parent):
        for i, child in enumerate(parent):
            if child.tag != "bsdf":
                continue
            if id(child) not in seen:
                seen[id(child)] = child
                visit(child)
                continue
            if child.get("id") is None:
                child.set("id", unique_id())
            parent[i] = reference(child.get("id"))
    visit(element)


class Names:
    """Turns Blender's names into unique identifiers and file names."""

    def __init__(self):
        self._taken = set()

    def unique(self, name):
        base = re.sub(r"[^A-Za-z0-9_-]+", "_", name).strip("_") or "unnamed"
        result, count = base, 2
        while result.lower() in self._taken:  # file systems may ignore case
            result, count = f"{base}_{count}", count + 1
        self._taken.add(result.lower())
        return result


def write(scene, path):
    """Writes a scene, indented, to a file. The file is complete or isn't changed."""
    ET.indent(scene, "    ")
    temporary = f"{path}.part"
    with open(temporary, "wb") as file:
        ET.ElementTree(scene).write(file, encoding="utf-8")
        file.write(b"\n")
    os.replace(temporary, path)
