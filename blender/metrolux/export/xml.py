"""Elements of a Mitsuba scene."""

import xml.etree.ElementTree as ElementTree


def number(value):
    """A number with the digits of single precision, or all that a double has where it is one."""
    return repr(round(float(value), 9))


def plugin(tag, kind, name=None, **values):
    """An element with a type; `values` are bool, int, float, str, or elements, which get the name of their keyword."""
    element = ElementTree.Element(tag, {"type": kind})
    if name:
        element.set("name", name)
    for key, value in values.items():
        add(element, key, value)
    return element


def add(element, key, value):
    if isinstance(value, ElementTree.Element):
        value.set("name", key)
        element.append(value)
        return
    for kind, tag, text in (
        (bool, "boolean", lambda v: "true" if v else "false"),
        (int, "integer", str),
        (float, "float", number),
        (str, "string", str),
    ):
        if isinstance(value, kind):
            ElementTree.SubElement(element, tag, {"name": key, "value": text(value)})
            return
    raise TypeError(f"{key}: found {type(value).__name__}, expected a bool, int, float, str or element")


def rgb(color):
    return ElementTree.Element("rgb", {"value": ", ".join(number(c) for c in color[:3])})


def scalar(value):
    return ElementTree.Element("float", {"value": number(value)})


def vector(tag, values):
    return ElementTree.Element(tag, dict(zip("xyz", (number(v) for v in values))))


def transform(rows):
    """A <transform> of a matrix given as rows."""
    element = ElementTree.Element("transform")
    text = " ".join(repr(float(v)) for row in rows for v in row)
    ElementTree.SubElement(element, "matrix", {"value": text})
    return element


def reference(name):
    return ElementTree.Element("ref", {"id": name})


def write(path, scene):
    ElementTree.indent(scene, "  ")
    ElementTree.ElementTree(scene).write(path, encoding="utf-8", xml_declaration=True)
