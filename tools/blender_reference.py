"""Makes the tables of the page of the Blender add-on anew: blender -b -P tools/blender_reference.py -- docs/reference/blender.md"""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "blender"))

from metrolux.export import reference_page  # noqa: E402

path = sys.argv[-1]
with open(path, encoding="utf-8") as file:
    page = file.read()
with open(path, "w", encoding="utf-8") as file:
    file.write(reference_page.updated(page))
