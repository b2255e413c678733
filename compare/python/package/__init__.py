"""concord: a multibody machine solved twice, and every joint reaction compared.

Units are SI and radians. Shapes, units and frames of all arrays: the stub `__init__.pyi` beside this file, and
compare/python/README.md. Names are those of the program's JSON and NetCDF files.
"""

import json as _json

from . import _native
from ._history import History, history
from ._native import (
    Diagnostic,
    Evaluation,
    InputError,
    Model,
    Rank,
    Run,
    SingularPose,
    Solver,
    SolverError,
    State,
)

__version__ = _native.version
__all__ = [
    "Diagnostic", "Evaluation", "History", "InputError", "Model", "Rank", "Run", "SingularPose", "Solver",
    "SolverError", "State", "Verdict", "compare", "history", "load", "run",
]

for _type in (Evaluation, Model, Rank, Run, Solver, State):
    _type.__module__ = __name__
del _type


class Verdict(dict):
    """What `concord compare --json` writes, as dictionaries, and what the program says beside it."""

    def __init__(self, compared):
        super().__init__(_json.loads(compared.json))
        self._compared = compared

    @property
    def json(self):
        """The text that the program writes."""
        return self._compared.json

    def table(self, all=False):
        """The table that the program prints; `all`: every component."""
        return self._compared.table(all)

    @property
    def findings(self):
        """Differences: what, and what it looks like."""
        return self._compared.findings

    @property
    def notes(self):
        """What the reader must know, no difference."""
        return self._compared.notes

    @property
    def failures(self):
        """Why there is no verdict."""
        return self._compared.failures

    @property
    def runs(self):
        """Both solvers' runs by name; None where a solver did not finish."""
        return self._compared.runs

    def __reduce__(self):
        return dict, (dict(self),)


def load(path, parameters=None):
    """Reads a model file; `parameters` replace those that the file defines."""
    return _native.load(path, parameters=parameters or {})


def compare(model, *, until=None, rtol=None, samples=None, cartesian="", relative="", seed=None, reference=None):
    """Solves a model, or the model in a file, by both solvers and judges every joint reaction; `reference` is a file
    of values from another source that both are held against."""
    asked = {"until": until, "rtol": rtol, "samples": samples, "seed": seed, "reference": reference}
    return Verdict(_native.compare(_model(model), cartesian=cartesian, relative=relative, **asked))


def run(model, solver, *, until=None, rtol=None, samples=None, integrator=""):
    """Integrates a model, or the model in a file, with one solver, and holds the run against its own audit."""
    return _native.run(_model(model), solver, until=until, rtol=rtol, samples=samples, integrator=integrator)


def _model(model):
    return model if isinstance(model, Model) else load(model)
