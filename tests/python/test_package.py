"""The package as a whole: stubs, docstrings, memory, the time to import, installing."""

import ast
import importlib
import inspect
import os
import pathlib
import re
import resource
import subprocess
import sys
import unittest

from support import SOURCE, TestCase, ball

import metrolux

PACKAGE = pathlib.Path(metrolux.__file__).parent
EXTENSION = importlib.import_module("metrolux._metrolux")


def parameters_of_stub(function):
    """[(name, default)] of a definition of the stubs, with "*" where keywords begin."""
    a = function.args
    positional = a.posonlyargs + a.args
    defaults = [None] * (len(positional) - len(a.defaults)) + a.defaults
    result = [(p.arg, d and ast.literal_eval(d)) for p, d in zip(positional, defaults, strict=True)]
    if a.kwonlyargs:
        result.append(("*", None))
        result += [(p.arg, d and ast.literal_eval(d)) for p, d in zip(a.kwonlyargs, a.kw_defaults, strict=True)]
    if a.kwarg:
        result.append(("**", None))
    return result


def parameters_of(function):
    """The same of what is there: of an extension's function by the first line of its docstring."""
    if inspect.isfunction(function):
        result = []
        for p in inspect.signature(function).parameters.values():
            if p.kind is p.KEYWORD_ONLY and ("*", None) not in result:
                result.append(("*", None))
            result.append((p.name, None if p.default is p.empty else p.default))
        return result
    line = function.__doc__.splitlines()[0]
    text = line[line.index("(") : line.rindex(" ->")].replace("**kwargs", "**kwargs: object")
    text = re.sub(r"std::[\w:<> ]+(?= =)", "object", text)
    return parameters_of_stub(ast.parse(f"def f{text}: ...").body[0])


class Stubs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.tree = ast.parse((PACKAGE / "__init__.pyi").read_text())
        cls.classes = {node.name: node for node in cls.tree.body if isinstance(node, ast.ClassDef)}
        cls.functions = {node.name: node for node in cls.tree.body if isinstance(node, ast.FunctionDef)}

    def compare(self, function, stub, name):
        expected, found = parameters_of_stub(stub), parameters_of(function)
        if found and found[0][0] == "self":
            found[0] = expected[0]
        self.assertEqual(expected, found, name)

    def test_have_all_names(self):
        public = {name for name in vars(metrolux) if not name.startswith("_")}
        self.assertEqual(public, set(metrolux.__all__))
        self.assertEqual(public, set(self.classes) | set(self.functions))

    def test_functions_agree(self):
        for name, stub in self.functions.items():
            self.compare(getattr(metrolux, name), stub, name)

    def test_classes_agree(self):
        for name, node in self.classes.items():
            own = vars(getattr(metrolux, name))
            stubs = {m.name: m for m in node.body if isinstance(m, ast.FunctionDef)}
            attributes = {m.target.id for m in node.body if isinstance(m, ast.AnnAssign)}
            members = {m for m in own if not m.startswith("_") or m in ("__iter__", "__next__", "__matmul__")}
            if issubclass(getattr(metrolux, name), BaseException):  # set where they are raised
                self.assertEqual(attributes, {"image"})
                continue
            self.assertEqual(members, attributes | set(stubs) - {"__init__"}, name)
            for member, stub in stubs.items():
                if any(isinstance(d, ast.Name) and d.id == "property" for d in stub.decorator_list):
                    self.assertTrue(isinstance(own[member], property), f"{name}.{member}")
                elif not any(isinstance(d, ast.Name) and d.id == "overload" for d in stub.decorator_list):
                    self.compare(own[member], stub, f"{name}.{member}")

    def test_know_the_integrators(self):
        for node in self.tree.body:
            if isinstance(node, ast.Assign) and node.targets[0].id == "_IntegratorName":
                names = set(ast.literal_eval(node.value.slice))
        self.assertEqual(names, set(metrolux.integrators()) | {"scene"})

    def test_everything_is_described(self):
        for name in metrolux.__all__:
            thing = getattr(metrolux, name)
            self.assertTrue(thing.__doc__, name)
            if isinstance(thing, type):
                for member, value in vars(thing).items():
                    if not member.startswith("_") and (callable(value) or isinstance(value, property)):
                        self.assertTrue(re.sub(r"^\w+\(self.*", "", value.__doc__ or "").strip(), f"{name}.{member}")


class Integrators(unittest.TestCase):
    def test_describe_their_keywords(self):
        parameter = metrolux.integrators()["mcmc_vcm"].parameters["radius_alpha"]
        self.assertEqual((parameter.default, parameter.expected), (0.75, "a number from 0 to 1"))
        self.assertEqual(next(iter(metrolux.integrators())), "mcmc_vcm")
        self.assertIn("mcmc_vcm: VCM", metrolux.Scene.render.__doc__)


class Memory(unittest.TestCase):
    def resident(self):
        pages = int(pathlib.Path("/proc/self/statm").read_text().split()[1])
        return pages * resource.getpagesize()

    def test_loads_and_renders_leave_nothing(self):
        """A scene whose mesh takes 9 MB: fifty of which one in ten stayed would be seen."""
        import numpy

        n = 256
        x, y = numpy.meshgrid(numpy.arange(n), numpy.arange(n), indexing="ij")
        corner = (x * n + y)[:-1, :-1].reshape(-1)
        positions = numpy.stack([x, 0 * x, y], axis=-1).reshape(-1, 3) * (6 / n) - 3
        triangles = numpy.concatenate(
            [numpy.stack([corner, corner + 1, corner + n + 1], 1), numpy.stack([corner, corner + n + 1, corner + n], 1)]
        )

        def once():
            mesh = metrolux.Mesh(positions, triangles)
            scene = metrolux.load_dict(ball(floor={"type": "mesh", "arrays": mesh}))
            scene = scene.with_values({"gray.reflectance": 0.25})
            session = scene.session("path", passes=1)
            views = list(session)
            return scene.render("vcm", passes=1, layers=["albedo"]).mean() + views[-1].mean()

        for _ in range(5):
            once()
        before = self.resident()
        for _ in range(50):
            once()
        self.assertLess(self.resident() - before, 40e6)


class Import(unittest.TestCase):
    def test_takes_less_than_three_tenths_of_a_second(self):
        """Of processor time, numpy included: others may use the machine."""
        code = "import time; start = time.process_time(); import metrolux; print(time.process_time() - start)"
        runs = (subprocess.run([sys.executable, "-c", code], check=True, capture_output=True) for _ in range(5))
        times = [float(run.stdout) for run in runs]
        self.assertLess(min(times), 0.3, times)


class Install(TestCase):
    def test_an_installed_package_needs_nothing_of_the_build(self):
        build = pathlib.Path(os.environ["METROLUX_BINARY_DIR"])
        command = ["cmake", "--install", build, "--component", "python", "--prefix", self.folder]
        subprocess.run(command, check=True, capture_output=True)
        names = sorted(p.name for p in (self.folder / "metrolux").iterdir())
        self.assertEqual(names[:3], ["__init__.py", "__init__.pyi", EXTENSION.__file__.rsplit("/", 1)[1]])
        self.assertTrue(names[3].startswith("libmetrolux.so."), names)
        self.assertEqual(names[4:], ["py.typed"])
        code = (
            "import metrolux; print(metrolux.__file__); "
            "print([l.split()[-1] for l in open('/proc/self/maps') if 'libmetrolux' in l][0])"
        )
        environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"} | {"PYTHONPATH": str(self.folder)}
        result = subprocess.run(
            [sys.executable, "-c", code], env=environment, cwd=self.folder, check=True, capture_output=True, text=True
        )
        for file in result.stdout.split():
            self.assertTrue(file.startswith(str(self.folder)), result.stdout)

    def test_has_the_version_of_the_library(self):
        text = (SOURCE / "CMakeLists.txt").read_text()
        self.assertEqual(metrolux.__version__, re.search(r"project\(Metrolux VERSION ([\d.]+)", text)[1])


if __name__ == "__main__":
    unittest.main()
