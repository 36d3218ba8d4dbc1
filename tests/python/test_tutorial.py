"""The tutorials' scripts, in short; and that their pages have the same code."""

import re
import subprocess
import sys
import unittest

from support import BALL_XML, SOURCE, TestCase

import metrolux

try:
    import matplotlib  # noqa: F401
except ImportError:
    print("python.tutorial: Skipped\nfor want of python3-matplotlib")
    raise SystemExit(0) from None

FOLDER = SOURCE / "docs" / "tutorial"


class Tutorial(TestCase):
    def run_script(self, name, *arguments):
        command = [sys.executable, FOLDER / "python" / name, *map(str, arguments)]
        result = subprocess.run(command, cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout

    def test_first_render(self):
        output = self.run_script("first_render.py", 0.3)
        self.assertIn("<metrolux.Scene scene, 400x300 pixels, 25603 primitives, 2 lights>", output)
        self.assertEqual(metrolux.read(self.folder / "ring.png").shape, (300, 400, 3))
        self.assertEqual(metrolux.read(self.folder / "red.png").shape, (150, 200, 3))

    def test_comparing(self):
        file = self.write("ball.xml", BALL_XML)
        reference = metrolux.load(file).render("bdpt", passes=200)
        reference.save(self.folder / "reference.exr")
        output = self.run_script("compare.py", file, "reference.exr", 0.3)
        self.assertEqual(len(re.findall("passes, trimmed relMSE", output)), 3, output)
        self.assertGreater((self.folder / "curves.png").stat().st_size, 1000)

    def test_lamp(self):
        output = self.run_script("lamp.py", 8)
        angle = float(re.findall(r"step 8: ([\d.]+) degrees", output)[0])
        self.assertAlmostEqual(angle, 25, delta=0.5)
        self.assertGreater((self.folder / "lamp.png").stat().st_size, 1000)

    def test_pages_have_the_code_of_the_scripts(self):
        for page, script in (("python", "first_render"), ("python-comparing", "compare"), ("python-lamp", "lamp")):
            blocks = re.findall(r"```python\n(.*?)```", (FOLDER / f"{page}.md").read_text(), re.DOTALL)
            shown = [line for line in "".join(blocks).splitlines() if line]
            code = (FOLDER / "python" / f"{script}.py").read_text()
            lines = [line for line in code.splitlines() if line and "sys" not in line]
            self.assertEqual(shown, lines, page)

    def test_pictures_are_small(self):
        for picture in (FOLDER / "pictures").glob("python-*.png"):
            self.assertLess(picture.stat().st_size, 400e3, picture)


if __name__ == "__main__":
    unittest.main()
