"""The tables of docs/reference/blender.md, from what the exporter's modules say of themselves."""

from . import lights, normals, shaders, textures, volumes, world

_TABLES = {
    "shaders": ("shader", shaders.SHADERS),
    "volumes": ("volume", volumes.VOLUMES),
    "textures": ("node", {**textures.NODES, **normals.NODES, **world.NODES}),
    "lights": ("light", lights.LIGHTS),
}


def _table(head, entries):
    rows = sorted((entry[0], entry[1]) for entry in entries.values())
    return "\n".join([f"| {head} | becomes |", "|---|---|", *(f"| {name} | {becomes} |" for name, becomes in rows)])


def updated(page):
    """The page with its tables made anew: each stands between <!-- name --> and <!-- end -->."""
    for name, (head, entries) in _TABLES.items():
        before, rest = page.split(f"<!-- {name} -->\n", 1)
        _, after = rest.split("<!-- end -->", 1)
        page = f"{before}<!-- {name} -->\n{_table(head, entries)}\n<!-- end -->{after}"
    return page
