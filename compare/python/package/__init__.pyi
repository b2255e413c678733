"""What the package `concord` offers: shapes, units and frames.

SI units and radians. B bodies, ground first, in the order of `Model.bodies`; J joints, E force elements, C couplings; T
samples of a run. A wrench is [F_x, F_y, F_z, T_x, T_y, T_z] in N and N m. Sides of a joint: 0 its parent, 1 its child;
the wrench on a side acts at that side's joint point. Places, velocities and accelerations are those of the origins of
the bodies' frames, in global axes.
"""

from os import PathLike
from typing import Any, Mapping, NamedTuple, Optional, Sequence, Union

import numpy as np
import pandas

__version__: str

class Diagnostic(NamedTuple):
    """A complaint and its place; lines and columns count from 1, 0: not known."""

    file: str
    line: int
    column: int
    message: str

class InputError(ValueError):
    """Bad input; the program would end with 2. The text: `file:line:column: error: message`, a line for each."""

    diagnostics: Sequence[Diagnostic]

class SolverError(RuntimeError):
    """A solver could not finish; the text says which one, when, where and why. The program would end with 3."""

class SingularPose(SolverError):
    """A pose in which the constraints lose rank."""

class Model:
    """The statement of a machine, as read from a file."""

    @property
    def name(self) -> str: ...
    @property
    def file(self) -> str: ...
    @property
    def bodies(self) -> tuple[str, ...]:
        """B names, "ground" first: the order of all arrays."""
    @property
    def modes(self) -> tuple[int, ...]:
        """Number of modal coordinates of each body."""
    @property
    def joints(self) -> tuple[str, ...]: ...
    @property
    def joint_types(self) -> tuple[str, ...]: ...
    @property
    def joint_ends(self) -> tuple[tuple[str, str], ...]:
        """Names of parent and child of each joint."""
    @property
    def couplings(self) -> tuple[str, ...]: ...
    @property
    def elements(self) -> tuple[str, ...]: ...
    @property
    def gravity(self) -> np.ndarray:
        """(3,) [m/s2], global axes; a read-only view."""
    @property
    def until(self) -> float:
        """Length of the run that the model asks for [s]."""
    @property
    def is_flexible(self) -> bool: ...

class State:
    """A complete state of a machine. Its arrays are views that can be written; they keep the state alive.

    `State(model)` is at rest at the origin with zeros for all else: a place to start filling in, closed by no means.
    """

    time: float
    def __init__(self, model: Model) -> None: ...
    @property
    def position(self) -> np.ndarray:
        """(B, 3) [m]."""
    @property
    def euler_parameters(self) -> np.ndarray:
        """(B, 4), body to global axes, scalar first, of unit length."""
    @property
    def velocity(self) -> np.ndarray:
        """(B, 3) [m/s]."""
    @property
    def angular_velocity(self) -> np.ndarray:
        """(B, 3) [rad/s], global axes."""
    @property
    def modal_coordinates(self) -> list[np.ndarray]:
        """B arrays, each as long as the body has modes."""
    @property
    def modal_velocities(self) -> list[np.ndarray]:
        """B arrays [1/s]."""
    @property
    def joint_coordinates(self) -> list[np.ndarray]:
        """J arrays [rad, m], turns counted: hints for the number of turns; all else follows from the bodies."""
    @property
    def joint_speeds(self) -> list[np.ndarray]:
        """J arrays [rad/s, m/s]: hints."""
    @property
    def spring_angles(self) -> np.ndarray:
        """(E,) [rad] of each force element that is a turn spring, turns counted: hints for the number of turns; other
        elements have none."""
    def copy(self) -> State: ...
    def __copy__(self) -> State: ...
    def __deepcopy__(self, memo: dict) -> State: ...

class Rank:
    """Rank of the constraints in one state, and what is unique there. Arrays are read-only views."""

    @property
    def constraints(self) -> int:
        """Rows, drivers included, lengths of Euler parameters not."""
    @property
    def rank(self) -> int: ...
    @property
    def degrees_of_freedom(self) -> int:
        """Rigid and modal ones."""
    @property
    def undecided(self) -> bool:
        """A singular value lies between 1e-12 and 1e-8 of the largest."""
    @property
    def smallest_kept(self) -> float: ...
    @property
    def largest_dropped(self) -> float: ...
    @property
    def unique(self) -> np.ndarray:
        """(J, 2, 6) bool: components of the reactions."""
    @property
    def unique_total(self) -> np.ndarray:
        """(J, 2, 6) bool: components of the total wrenches."""
    @property
    def unique_coordinate_force(self) -> np.ndarray:
        """(J, 6) bool, by speed of the joint."""
    @property
    def unique_driver_force(self) -> np.ndarray:
        """(J, 6) bool, by speed of the joint: of the driver's share alone."""
    @property
    def unique_coupling_force(self) -> np.ndarray:
        """(C,) bool, a copy; empty: all are unique."""
    @property
    def decided(self) -> np.ndarray:
        """(J, 2, 6) bool: whether `unique` stays when the thresholds that decide it move by 1000."""
    @property
    def decided_total(self) -> np.ndarray: ...
    @property
    def decided_coordinate_force(self) -> np.ndarray: ...
    @property
    def decided_driver_force(self) -> np.ndarray: ...
    @property
    def decided_coupling_force(self) -> np.ndarray: ...

class Evaluation:
    """What a solver says of one state. Arrays are read-only views that keep the evaluation alive."""

    @property
    def acceleration(self) -> np.ndarray:
        """(B, 3) [m/s2]."""
    @property
    def angular_acceleration(self) -> np.ndarray:
        """(B, 3) [rad/s2], global axes."""
    @property
    def modal_accelerations(self) -> list[np.ndarray]:
        """B arrays [1/s2]."""
    @property
    def reaction(self) -> np.ndarray:
        """(J, 2, 6) [N, N m]: on each side, in that side's joint frame; without what drivers and springs exert."""
    @property
    def reaction_global(self) -> np.ndarray:
        """(J, 2, 6): the same in global axes."""
    @property
    def total(self) -> np.ndarray:
        """(J, 2, 6): all that passes through the joint, in the side's joint frame."""
    @property
    def total_global(self) -> np.ndarray:
        """(J, 2, 6): the same in global axes."""
    @property
    def coordinate_force(self) -> list[np.ndarray]:
        """J arrays [N m, N]: force of driver, motor, spring, damper and couplings on each speed of the joint."""
    @property
    def driver_force(self) -> list[np.ndarray]:
        """J arrays [N m, N]: what of it the driver exerts; zero where there is none."""
    @property
    def motor_force(self) -> list[np.ndarray]:
        """The same of the motor."""
    @property
    def spring_force(self) -> list[np.ndarray]:
        """The same of springs and stops, as they are at rest."""
    @property
    def damper_force(self) -> list[np.ndarray]:
        """What the rate adds to that."""
    @property
    def element_wrench(self) -> np.ndarray:
        """(E, 2, 6): on each end, at its point, in its frame; zero on the parent that a load or a tire has not."""
    @property
    def element_wrench_global(self) -> np.ndarray:
        """(E, 2, 6): the same in global axes."""
    @property
    def coupling_force(self) -> np.ndarray:
        """(C,): times a term's factor it is its part of the coordinate force there."""
    @property
    def rank(self) -> Optional[Rank]:
        """None unless evaluate() was asked for uniqueness."""

class Run:
    """One solver's run as time series: read-only arrays, made when first asked for. Where a body or joint has fewer
    modes, coordinates or speeds than another one, the rest of its row is NaN. Names are those of the NetCDF files, which
    leave out ground."""

    @property
    def time(self) -> np.ndarray:
        """(T,) [s]."""
    @property
    def work(self) -> np.ndarray:
        """(T,) [J]: of drivers, springs, force elements and modal damping since the start."""
    @property
    def position(self) -> np.ndarray:
        """(T, B, 3)."""
    @property
    def euler_parameters(self) -> np.ndarray:
        """(T, B, 4)."""
    @property
    def velocity(self) -> np.ndarray:
        """(T, B, 3)."""
    @property
    def angular_velocity(self) -> np.ndarray:
        """(T, B, 3)."""
    @property
    def acceleration(self) -> np.ndarray:
        """(T, B, 3)."""
    @property
    def angular_acceleration(self) -> np.ndarray:
        """(T, B, 3)."""
    @property
    def modal_coordinates(self) -> np.ndarray:
        """(T, B, most modes)."""
    @property
    def modal_velocities(self) -> np.ndarray: ...
    @property
    def modal_accelerations(self) -> np.ndarray: ...
    @property
    def joint_coordinates(self) -> np.ndarray:
        """(T, J, most coordinates)."""
    @property
    def joint_speeds(self) -> np.ndarray:
        """(T, J, most speeds)."""
    @property
    def coordinate_force(self) -> np.ndarray:
        """(T, J, most speeds); nan where it is not unique, unless the run is by Solver.run(). So are all that follow but
        those of springs and dampers, which are laws."""
    @property
    def driver_force(self) -> np.ndarray:
        """(T, J, most speeds): what of the coordinate force the driver exerts."""
    @property
    def motor_force(self) -> np.ndarray: ...
    @property
    def spring_force(self) -> np.ndarray: ...
    @property
    def damper_force(self) -> np.ndarray: ...
    @property
    def reaction(self) -> np.ndarray:
        """(T, J, 2, 6): as in Evaluation; so are the next three."""
    @property
    def reaction_global(self) -> np.ndarray: ...
    @property
    def total(self) -> np.ndarray: ...
    @property
    def total_global(self) -> np.ndarray: ...
    @property
    def coupling_force(self) -> np.ndarray:
        """(T, C)."""
    @property
    def any_coordinate_force(self) -> np.ndarray:
        """The solver's own values, also where they are not unique and coordinate_force is nan; so are the next six."""
    @property
    def any_driver_force(self) -> np.ndarray: ...
    @property
    def any_reaction(self) -> np.ndarray: ...
    @property
    def any_reaction_global(self) -> np.ndarray: ...
    @property
    def any_total(self) -> np.ndarray: ...
    @property
    def any_total_global(self) -> np.ndarray: ...
    @property
    def any_coupling_force(self) -> np.ndarray: ...
    @property
    def element_wrench(self) -> np.ndarray:
        """(T, E, 2, 6)."""
    @property
    def element_wrench_global(self) -> np.ndarray: ...
    @property
    def unique(self) -> Optional[np.ndarray]:
        """(T, J, 2, 6) bool: components of the reactions; None for a run by Solver.run()."""
    @property
    def model(self) -> Model:
        """The model as it ran: started where the comparison put it."""
    @property
    def solver(self) -> str: ...
    @property
    def integrator(self) -> str: ...
    @property
    def rtol(self) -> float: ...
    @property
    def check(self) -> str:
        """Audit and energy in words, by concord.run(); else empty."""
    @property
    def steps(self) -> int: ...
    @property
    def evaluations(self) -> int: ...
    @property
    def wall_s(self) -> float: ...
    def state(self, sample: int) -> State:
        """A copy of the state of a sample."""
    def evaluation(self, sample: int) -> Evaluation:
        """A copy of what the solver found there."""
    def __len__(self) -> int: ...
    def write_netcdf(self, path: Union[str, PathLike[str]]) -> None:
        """The file that `concord run --out` writes."""

class Solver:
    """One solver, "cartesian" or "relative", bound to one model as it is written. One thread at a time works in it."""

    def __init__(self, model: Model, name: str) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def model(self) -> Model: ...
    @property
    def integrators(self) -> list[str]:
        """The default for this model first."""
    @property
    def cut_joints(self) -> list[str]: ...
    def start(self) -> State:
        """The start of the model, loops closed."""
    def close(self, guess: State) -> Optional[State]:
        """The closed state near the guess, None where there is none; modal coordinates and rates are kept."""
    def evaluate(self, state: State, *, uniqueness: bool = False) -> Evaluation:
        """Accelerations and wrenches in a closed state, taken as it is. Raises SolverError where it is not closed."""
    def rank(self, state: State) -> Rank:
        """What is unique in a closed state; costs what up to twenty evaluations cost."""
    def run(
        self,
        times: Optional[Sequence[float]] = None,
        *,
        until: Optional[float] = None,
        samples: Optional[int] = None,
        rtol: Optional[float] = None,
        integrator: str = "",
        start: Optional[State] = None,
    ) -> Run:
        """Integrates from the start of the model, or from a closed state of time 0. `times` rise from 0 in equal steps;
        `until` and `samples` say the same. What is missing comes from the model."""

class Verdict(dict[str, Any]):
    """What `concord compare --json` writes, as dictionaries (compare/report/README.md), and what is said beside it."""

    @property
    def json(self) -> str:
        """The text that the program writes."""
    def table(self, all: bool = False) -> str:
        """The table that the program prints; `all`: every component."""
    @property
    def findings(self) -> list[tuple[str, str]]:
        """Differences: what, and what it looks like."""
    @property
    def notes(self) -> list[str]:
        """What the reader must know, no difference."""
    @property
    def failures(self) -> list[str]:
        """Why there is no verdict."""
    @property
    def runs(self) -> dict[str, Optional[Run]]:
        """Both solvers' runs, "cartesian" and "relative"; None where a solver did not finish."""

class History(NamedTuple):
    """Tables of the nightly history (compare/nightly/README.md): one row for each night, by its number; each case of a
    night; each component of such a case, with digits and peak values, NaN where a rung did not judge it."""

    nights: pandas.DataFrame
    results: pandas.DataFrame
    components: pandas.DataFrame

def load(path: Union[str, PathLike[str]], parameters: Optional[Mapping[str, float]] = None) -> Model:
    """Reads a model file; `parameters` replace those that the file itself defines."""

def compare(
    model: Union[Model, str, PathLike[str]],
    *,
    until: Optional[float] = None,
    rtol: Optional[float] = None,
    samples: Optional[int] = None,
    cartesian: str = "",
    relative: str = "",
    seed: Optional[int] = None,
    reference: Optional[Union[str, PathLike[str]]] = None,
) -> Verdict:
    """What `concord compare` does; `cartesian` and `relative` name integrators, `seed` is that of the random states,
    `reference` a file as for `--reference`.
    Ctrl-C interrupts it."""

def run(
    model: Union[Model, str, PathLike[str]],
    solver: str,
    *,
    until: Optional[float] = None,
    rtol: Optional[float] = None,
    samples: Optional[int] = None,
    integrator: str = "",
) -> Run:
    """What `concord run` does: SolverError where the run's own audit or energy refutes it. Ctrl-C interrupts it."""

def history(file: Union[str, PathLike[str]]) -> History:
    """Reads the file that `concord nightly --history` writes; needs pandas. A file of another version is refused."""
