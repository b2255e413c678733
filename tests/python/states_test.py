"""One state, lifetimes of views, and long work of the Python module.

Each test says which mistake it detects.
"""

import copy
import gc
import os
import pathlib
import signal
import sys
import threading
import time
import unittest

import concord
import numpy as np

MODELS = pathlib.Path(os.environ["CONCORD_DATA"]) / "models"


class SameState(unittest.TestCase):
    def setUp(self):
        self.model = concord.load(MODELS / "slider_crank_flexible.toml")
        self.solvers = [concord.Solver(self.model, name) for name in ("cartesian", "relative")]

    def test_both_solvers_agree_in_a_state(self):
        """Detects sides, frames or joints that are mixed up."""
        state = self.solvers[1].run(until=0.02, samples=10).state(7)
        first, second = (solver.evaluate(state, uniqueness=True) for solver in self.solvers)
        unique = first.rank.unique & second.rank.unique
        self.assertTrue(unique.all() and first.rank.decided.all())
        scale = np.abs(first.reaction).max()
        np.testing.assert_allclose(first.reaction, second.reaction, atol=1e-10 * scale)
        np.testing.assert_allclose(first.total_global, second.total_global, atol=1e-10 * scale)
        # What acts on one side acts opposite on the other: forces of revolute joints meet in one point.
        np.testing.assert_allclose(first.reaction_global[1, 0, :3], -first.reaction_global[1, 1, :3], atol=1e-9 * scale)
        self.assertIsNone(self.solvers[0].evaluate(state).rank)
        self.assertEqual(first.rank.degrees_of_freedom, 2)

    def test_redundant_reactions_are_flagged(self):
        """Detects flags that are read from the wrong place."""
        model = concord.load(MODELS / "two_hinge_door.toml")
        solver = concord.Solver(model, "cartesian")
        rank = solver.rank(solver.start())
        self.assertLess(rank.rank, rank.constraints)
        self.assertTrue(rank.unique.any() and not rank.unique.all())
        run = concord.run(model, "cartesian", until=0.1, samples=2)
        np.testing.assert_array_equal(run.unique[0], rank.unique)

    def test_a_state_can_be_changed_and_closed(self):
        """Detects views that are copies, a copy that is a view, and a ground that is moved unnoticed."""
        solver = self.solvers[0]
        state = solver.start()
        twin = copy.copy(state)
        state.position[1] += 0.001
        self.assertEqual(state.position[1, 0], twin.position[1, 0] + 0.001)
        with self.assertRaisesRegex(concord.SolverError, "not closed"):
            solver.evaluate(state)
        moved = copy.copy(twin)
        moved.position[0, 1] = 0.5
        with self.assertRaisesRegex(concord.InputError, "the ground, body 0 of a state, was moved"):
            solver.evaluate(moved)
        closed = solver.close(state)
        self.assertTrue(np.isfinite(solver.evaluate(closed).reaction).all())
        state.position[...] = twin.position
        np.testing.assert_array_equal(solver.evaluate(state).reaction, solver.evaluate(twin).reaction)

    def test_states_of_other_machines_are_refused(self):
        """Detects a state that is read beyond its end."""
        other = concord.State(concord.load(MODELS / "compound_pendulum.toml"))
        for solver in self.solvers:
            for ask in (solver.evaluate, solver.close, solver.rank):
                with self.assertRaisesRegex(concord.InputError, "the state has 2 bodies .* has 4"):
                    ask(other)
        rigid = concord.Solver(concord.load(MODELS / "slider_crank_rigid.toml"), "relative").start()
        with self.assertRaisesRegex(concord.InputError, "0 modal coordinates of body 'coupler', .* has 2"):
            self.solvers[0].evaluate(rigid)

    def test_a_number_that_is_not_finite_is_refused(self):
        """Detects NaN that passes for a closed state."""
        for spoil in (lambda one: one.velocity, lambda one: one.modal_coordinates[2], lambda one: one.joint_speeds[0]):
            state = self.solvers[0].start()
            spoil(state).flat[0] = np.nan
            with self.assertRaisesRegex(concord.InputError, "not finite"):
                self.solvers[0].evaluate(state)
        state = self.solvers[0].start()
        state.euler_parameters[1] = 0
        for solver in self.solvers:
            with self.assertRaises((concord.SolverError, concord.InputError)):
                solver.evaluate(state)

    def test_a_turn_spring_counts_the_turns_that_a_state_says(self):
        """Detects turns of a spring between bodies that are lost on the way to a solver."""
        model = concord.load(MODELS / "torsion_pendulum.toml")
        for name in ("cartesian", "relative"):
            solver = concord.Solver(model, name)
            state = solver.start()
            torques = []
            for _ in range(3):
                torques.append(solver.evaluate(state).element_wrench[0, 1, 5])
                state.spring_angles[0] += 2 * np.pi
            np.testing.assert_allclose(torques[2] - torques[1], torques[1] - torques[0], rtol=1e-12)
            self.assertLess(torques[1], torques[0] - 0.1)
            self.assertAlmostEqual(solver.close(state).spring_angles[0], state.spring_angles[0], 12)

    def test_the_solver_has_a_known_name(self):
        """Detects a name that silently means one of the two."""
        with self.assertRaisesRegex(concord.InputError, "no solver 'Relative': known solvers: cartesian, relative"):
            concord.Solver(self.model, "Relative")
        with self.assertRaises(TypeError):
            concord.Solver(None, "relative")


class Lifetimes(unittest.TestCase):
    """Detects a view that outlives its memory: what it shows is overwritten by what is allocated next."""

    def test_views_outlive_their_owners(self):
        model = concord.load(MODELS / "slider_crank_flexible.toml")
        solver = concord.Solver(model, "cartesian")
        state = solver.start()
        found = solver.evaluate(state, uniqueness=True)
        views = {
            "gravity": model.gravity, "position": state.position, "modes": state.modal_coordinates[2],
            "reaction": found.reaction, "driver": found.coordinate_force[0], "flags": found.rank.unique,
        }
        kept = {name: np.array(view) for name, view in views.items()}
        del model, solver, state, found
        gc.collect()
        litter = [np.full(200, 7.7e77) for _ in range(2000)]
        other = concord.Solver(concord.load(MODELS / "slider_crank_flexible.toml"), "relative")
        litter.append([other.evaluate(other.start()) for _ in range(50)])
        for name, view in views.items():
            np.testing.assert_array_equal(view, kept[name], err_msg=name)

    def test_views_hold_their_owner_and_nothing_more(self):
        """Detects a cycle or a reference that is never given back: memory would grow."""
        solver = concord.Solver(concord.load(MODELS / "compound_pendulum.toml"), "relative")
        state = solver.start()
        before = sys.getrefcount(state)
        views = [state.position, state.velocity, *state.joint_coordinates]
        self.assertEqual(sys.getrefcount(state), before + len(views))
        self.assertIs(views[0].base, state)
        del views
        self.assertEqual(sys.getrefcount(state), before)

    def test_results_cannot_be_written(self):
        """Detects a result that a slip in a script changes."""
        solver = concord.Solver(concord.load(MODELS / "compound_pendulum.toml"), "relative")
        found = solver.evaluate(solver.start(), uniqueness=True)
        run = solver.run(until=0.1, samples=2)
        results = (found.reaction, found.acceleration, found.coordinate_force[0], found.rank.unique, run.reaction, run.time)
        for array in results:
            with self.assertRaises(ValueError):
                array[...] = 0
            with self.assertRaises(ValueError):
                array.setflags(write=True) if array.base is not None else array.__setitem__(..., 0)


class LongWork(unittest.TestCase):
    def interrupt(self, work):
        """Seconds until the work ends after Ctrl-C."""
        sent = []

        def press():
            sent.append(time.monotonic())
            signal.raise_signal(signal.SIGINT)

        timer = threading.Timer(0.5, press)
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            work()
        timer.join()
        return time.monotonic() - sent[0]

    def test_ctrl_c_ends_it(self):
        """Detects long work that goes on, or that takes Python with it."""
        model = concord.load(MODELS / "car.toml")
        solver = concord.Solver(model, "relative")
        long = {"until": 500.0, "samples": 100000}
        self.assertLess(self.interrupt(lambda: concord.compare(model, **long)), 10.0)
        self.assertLess(self.interrupt(lambda: concord.run(model, "cartesian", **long)), 10.0)
        self.assertLess(self.interrupt(lambda: solver.run(**long)), 10.0)
        self.assertTrue(np.isfinite(solver.evaluate(solver.start()).reaction).all())

    def test_other_threads_run_meanwhile(self):
        """Detects work that holds the interpreter."""
        model = concord.load(MODELS / "car.toml")
        turns = []
        done = threading.Event()
        counter = threading.Thread(target=lambda: [turns.append(time.sleep(0.001)) for _ in iter(done.is_set, True)])
        counter.start()
        began = time.monotonic()
        concord.run(model, "relative", until=1.0)
        took = time.monotonic() - began
        done.set()
        counter.join()
        self.assertGreater(len(turns), 20 * took)

    def test_threads_share_a_solver(self):
        """Detects two threads that work in one solver at the same time."""
        model = concord.load(MODELS / "car.toml")
        solver = concord.Solver(model, "cartesian")
        run = solver.run(until=0.2, samples=20)
        states = [run.state(k) for k in range(len(run))]
        expected = [solver.evaluate(state).reaction for state in states]
        wrong = []

        def ask():
            for _ in range(5):
                for state, reaction in zip(states, expected):
                    if not np.array_equal(solver.evaluate(state).reaction, reaction):
                        wrong.append(state.time)

        threads = [threading.Thread(target=ask) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(wrong, [])


if __name__ == "__main__":
    unittest.main(verbosity=2)
