"""Types of the package; what everything does, its docstrings say."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, overload

import numpy
from numpy.typing import ArrayLike, NDArray

__version__: str
__all__: list[str]

_File = str | PathLike[str]
_IntegratorName = Literal[
    "mcmc_vcm", "vcm", "bdpt", "path", "sppm", "light", "pssmlt", "pssmlt_merge", "mmlt", "vpt", "split_mcmc", "scene"
]  # fmt: skip
_Curve = Literal["srgb", "filmic", "none"]
_Layer = Literal["albedo", "normal", "depth", "variance", "alpha", "denoised"]
_Progress = Callable[[Progress], object] | None
_Parameter = bool | int | float | str
_Placement = Transform | ArrayLike

class Error(RuntimeError):
    image: Image | None

class Interrupted(KeyboardInterrupt):
    image: Image | None
    def __init__(self, image: Image | None) -> None: ...

class Image(numpy.ndarray[Any, numpy.dtype[numpy.float32]]):
    exposure: float
    curve: _Curve
    layers: Mapping[str, Image]
    statistics: Mapping[str, Any]
    def shown(self, *, exposure: float | None = None, curve: _Curve | None = None) -> Image: ...
    def save(self, file: _File) -> None: ...

class Transform:
    @overload
    def __init__(self) -> None: ...
    @overload
    def __init__(self, matrix: _Placement) -> None: ...
    def translate(self, offset: ArrayLike) -> Transform: ...
    def scale(self, factors: ArrayLike) -> Transform: ...
    def rotate(self, axis: ArrayLike, angle: float) -> Transform: ...
    def look_at(self, origin: ArrayLike, target: ArrayLike, up: ArrayLike) -> Transform: ...
    def __matmul__(self, arg0: Transform) -> Transform: ...
    @property
    def matrix(self) -> NDArray[numpy.float64]: ...
    @property
    def inverse(self) -> Transform: ...

class Mesh:
    def __init__(
        self,
        positions: ArrayLike,
        triangles: ArrayLike,
        *,
        normals: ArrayLike | None = None,
        uvs: ArrayLike | None = None,
        **kwargs: ArrayLike,
    ) -> None: ...
    @property
    def positions(self) -> NDArray[numpy.float32]: ...
    @property
    def triangles(self) -> NDArray[numpy.uint32]: ...

class Scene:
    def with_camera(self, camera: _Placement | dict[str, Any]) -> Scene: ...
    def with_film(
        self,
        *,
        resolution: tuple[int, int] | None = None,
        crop: tuple[int, int, int, int] | None = None,
        filter: str | None = None,
    ) -> Scene: ...
    def with_paths(
        self, *, max_depth: int | None = None, roulette_depth: int | None = None, hide_emitters: bool | None = None
    ) -> Scene: ...
    def with_values(self, changes: dict[str, Any]) -> Scene: ...
    @property
    def values(self) -> dict[str, Any]: ...
    @property
    def resolution(self) -> tuple[int, int]: ...
    @property
    def window(self) -> tuple[int, int, int, int]: ...
    @property
    def sizes(self) -> dict[str, int]: ...
    @property
    def integrator(self) -> str: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def source(self) -> str: ...
    def shares_geometry_with(self, other: Scene) -> bool: ...
    def session(
        self,
        integrator: _IntegratorName = "mcmc_vcm",
        *,
        time: float | None = None,
        passes: int | None = None,
        error: float | None = None,
        seed: int = 0,
        max_depth: int | None = None,
        layers: Sequence[_Layer] = (),
        threads: int = 0,
        memory: int = 1476395008,
        slices: int = 1,
        only_slices: tuple[int, int] | None = None,
        **kwargs: _Parameter,
    ) -> Session: ...
    def render(
        self,
        integrator: _IntegratorName = "mcmc_vcm",
        *,
        time: float | None = None,
        passes: int | None = None,
        error: float | None = None,
        seed: int = 0,
        max_depth: int | None = None,
        layers: Sequence[_Layer] = (),
        threads: int = 0,
        memory: int = 1476395008,
        slices: int = 1,
        only_slices: tuple[int, int] | None = None,
        progress: _Progress = None,
        output: _File | Sequence[_File] | None = None,
        overwrite: bool = False,
        exposure: float = 0.0,
        curve: _Curve = "srgb",
        save_every: float = 60,
        checkpoint: _File | None = None,
        checkpoint_every: float = 300,
        resume: _File | None = None,
        **kwargs: _Parameter,
    ) -> Image: ...

class Session(Iterator[Image]):
    def __iter__(self) -> Session: ...
    def __next__(self) -> Image: ...
    def step(self) -> Image: ...
    def render(
        self,
        *,
        time: float | None = None,
        passes: int | None = None,
        error: float | None = None,
        progress: _Progress = None,
        output: _File | Sequence[_File] | None = None,
        overwrite: bool = False,
        exposure: float = 0.0,
        curve: _Curve = "srgb",
        save_every: float = 60,
        checkpoint: _File | None = None,
        checkpoint_every: float = 300,
    ) -> Image: ...
    def stop(self) -> None: ...
    @property
    def image(self) -> Image: ...
    @property
    def variance(self) -> Image: ...
    @property
    def layers(self) -> dict[str, Image]: ...
    @property
    def progress(self) -> Progress: ...
    @property
    def statistics(self) -> dict[str, Any]: ...
    @property
    def scene(self) -> Scene: ...
    @property
    def integrator(self) -> str: ...
    @property
    def threads(self) -> int: ...
    def save(self, checkpoint: _File) -> None: ...
    def resume(self, checkpoint: _File) -> None: ...
    def save_image(self, file: _File, *, exposure: float = 0.0, curve: _Curve = "srgb") -> None: ...

class Progress:
    @property
    def passes(self) -> int: ...
    @property
    def seconds(self) -> float: ...
    @property
    def relative_error(self) -> float: ...
    @property
    def seconds_remaining(self) -> float | None: ...
    @property
    def rays_per_second(self) -> float: ...
    @property
    def note(self) -> str: ...

class Parameter:
    @property
    def name(self) -> str: ...
    @property
    def help(self) -> str: ...
    @property
    def default(self) -> _Parameter: ...
    @property
    def default_text(self) -> str: ...
    @property
    def expected(self) -> str: ...
    @property
    def choices(self) -> list[str]: ...

class Integrator:
    @property
    def name(self) -> str: ...
    @property
    def summary(self) -> str: ...
    @property
    def parameters(self) -> dict[str, Parameter]: ...

class Comparison:
    @property
    def mse(self) -> float: ...
    @property
    def rel_mse(self) -> float: ...
    @property
    def trimmed_rel_mse(self) -> float: ...
    @property
    def smape(self) -> float: ...
    @property
    def bias(self) -> float: ...
    @property
    def bias_error(self) -> float: ...
    @property
    def mean(self) -> float: ...
    @property
    def mean_reference(self) -> float: ...
    @property
    def pixels(self) -> int: ...
    @property
    def non_finite(self) -> int: ...
    @property
    def heat_map(self) -> Image: ...

def load(
    file: _File,
    *,
    define: Mapping[str, object] | None = None,
    lenient: bool = False,
    strict: bool = False,
    sensor: str = "",
    resolution: tuple[int, int] | None = None,
    crop: tuple[int, int, int, int] | None = None,
    filter: str | None = None,
    memory: int = 0,
    threads: int = 0,
    **kwargs: object,
) -> Scene: ...
def load_dict(
    scene: dict[str, Any],
    *,
    folder: _File = "",
    lenient: bool = False,
    strict: bool = False,
    sensor: str = "",
    resolution: tuple[int, int] | None = None,
    crop: tuple[int, int, int, int] | None = None,
    filter: str | None = None,
    memory: int = 0,
    threads: int = 0,
) -> Scene: ...
def read(file: _File) -> Image: ...
def write(file: _File, image: ArrayLike, *, exposure: float = 0.0, curve: _Curve = "srgb") -> None: ...
def png(image: ArrayLike, *, exposure: float = 0.0, curve: _Curve = "srgb") -> bytes: ...
def compare(image: ArrayLike, reference: ArrayLike, *, epsilon: float = 0.01) -> Comparison: ...
def integrators() -> dict[str, Integrator]: ...
def merge(
    parts: Sequence[_File],
    output: _File | Sequence[_File],
    *,
    overwrite: bool = False,
    exposure: float = 0.0,
    curve: _Curve = "srgb",
    layers: Sequence[_Layer] = (),
) -> dict[str, Any]: ...
