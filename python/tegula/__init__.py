"""Flexible multibody dynamics with thin and moderately thick shells.

A model is a model file, its text, a dictionary with the same keys, or objects of `tegula.parts`:

>>> import tegula
>>> model = tegula.Model({
...     "analysis": {"type": "static"},
...     "mesh": {"type": "plate", "size": [10.0, 1.0], "grid": {"elements": [20, 2]}},
...     "materials": {"steel": {"type": "isotropic", "young": 2.1e11, "poisson": 0.0}},
...     "sections": [{"material": "steel", "thickness": 0.1}],
...     "conditions": [{"type": "clamp", "on": "u_min"}],
...     "loads": [{"type": "edge", "on": "u_max", "value": [0.0, 0.0, -1e4]}],
...     "output": {"points": [{"name": "tip", "on": "u_max_v_min"}], "pictures": False},
... })
>>> result = model.run()
>>> print(round(result.history["tip.uz"][-1], 3))
-0.19

`Model.run` does what `tegula run` does; `Model.simulation` advances an analysis step by step, for controllers and for
coupling with other programs; `Model.equations` has residual, tangent stiffness and mass matrix as functions of a state.
"""

from typing import TYPE_CHECKING, Any

from ._equations import Equations, State
from ._errors import AnalysisError, Diagnostic, ModelError, ModelWarning, OutputError, TegulaError
from ._gmsh import from_gmsh
from ._knock_down import KnockDown, knock_down
from ._mesh import from_meshio, from_pyvista
from ._model import Model, run
from ._own import ElasticLaw, NodalForce
from ._progress import Progress
from ._result import FieldArrays, Fields, Frame, Result, StateSpace, Table
from ._simulation import Energies, Simulation, Statistics
from ._tegula import VERSION as __version__

if TYPE_CHECKING:
    from . import parts

__all__ = [
    "AnalysisError",
    "Diagnostic",
    "ElasticLaw",
    "Energies",
    "Equations",
    "FieldArrays",
    "Fields",
    "Frame",
    "KnockDown",
    "Model",
    "ModelError",
    "ModelWarning",
    "NodalForce",
    "OutputError",
    "Progress",
    "Result",
    "Simulation",
    "State",
    "StateSpace",
    "Statistics",
    "Table",
    "TegulaError",
    "__version__",
    "from_gmsh",
    "from_meshio",
    "from_pyvista",
    "knock_down",
    "parts",
    "run",
]


def __getattr__(name: str) -> Any:
    # The many classes would take a third of the time of `import tegula`; models from files and dictionaries need none.
    if name == "parts":
        import importlib

        return importlib.import_module(".parts", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
