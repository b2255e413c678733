"""Models, verdicts and runs of the Python module.

Each test says which mistake it detects.
"""

import json
import os
import pathlib
import pickle
import re
import subprocess
import tempfile
import unittest
import warnings

import concord
import numpy as np

PROGRAM = os.environ["CONCORD_PROGRAM"]
MODELS = pathlib.Path(os.environ["CONCORD_DATA"]) / "models"


def wall_times_left_out(text):
    return re.sub(r'"wall_s": [^,}\n]+', '"wall_s": 0', text)


def by_program(arguments, folder, code=0):
    """The text of --json."""
    file = pathlib.Path(folder) / "verdict.json"
    done = subprocess.run([PROGRAM, "compare", *arguments, "--json", file], check=False, capture_output=True)
    assert done.returncode == code, done.stderr
    return file.read_text(encoding="utf-8")


class Reading(unittest.TestCase):
    def test_names_stand_in_the_order_of_the_arrays(self):
        """Detects lists that leave out ground or are sorted."""
        model = concord.load(MODELS / "slider_crank_flexible.toml")
        self.assertEqual(model.bodies, ("ground", "crank", "coupler", "slider"))
        self.assertEqual(model.modes, (0, 0, 2, 0))
        self.assertEqual(model.joints, ("A", "B", "C", "D"))
        self.assertEqual(model.joint_types[1], "spherical")
        self.assertEqual(model.joint_ends[3], ("ground", "slider"))
        self.assertEqual(model.gravity.tolist(), [0, -9.81, 0])

    def test_every_error_has_its_place(self):
        """Detects an exception that loses the places, or all complaints but one."""
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "wrong.toml"
            file.write_text("format = 1\nfoo = 2\n[[body]]\nname = 'b'\nmas = 3\n", encoding="utf-8")
            with self.assertRaises(concord.InputError) as caught:
                concord.load(file)
        error = caught.exception
        self.assertIn(f"{file}:2:1: error: ", str(error))
        self.assertEqual((error.diagnostics[0].line, error.diagnostics[0].column), (2, 1))
        self.assertGreater(len(error.diagnostics), 1)
        self.assertIsInstance(error, ValueError)

    def test_a_missing_file_is_bad_input(self):
        """Detects an error of another kind for a file that is not there."""
        with self.assertRaisesRegex(concord.InputError, "nowhere.toml"):
            concord.load("nowhere.toml")

    def test_parameters_replace_those_of_the_file(self):
        """Detects values that are read but not used, and names that nothing defines."""
        model = MODELS / "slider_crank_rigid.toml"
        peaks = []
        for mass in (0.36, 0.72):
            changed = concord.load(model, parameters={"m_crank": mass})
            self.assertEqual(changed.name, "slider_crank_rigid")
            found = concord.Solver(changed, "relative")
            peaks.append(found.evaluate(found.start()).reaction_global[0, 1, 0])
        same = concord.Solver(concord.load(model), "relative")
        self.assertEqual(peaks[0], same.evaluate(same.start()).reaction_global[0, 1, 0])
        self.assertNotEqual(*peaks)
        with self.assertRaisesRegex(concord.InputError, "no parameter 'm_crnk': did you mean 'm_crank'"):
            concord.load(model, parameters={"m_crnk": 1})
        with self.assertRaisesRegex(concord.InputError, "m_crank.*nan"):
            concord.load(model, parameters={"m_crank": float("nan")})


class Comparing(unittest.TestCase):
    def test_the_verdict_is_that_of_the_program(self):
        """Detects other numbers, other defaults, or digits that are lost on the way."""
        for name in ("slider_crank_flexible", "car", "joint_springs_tree"):
            model = MODELS / f"{name}.toml"
            with tempfile.TemporaryDirectory() as folder:
                expected = wall_times_left_out(by_program([model, "--until", "0.02", "--samples", "40"], folder))
            verdict = concord.compare(model, until=0.02, samples=40)
            self.assertEqual(wall_times_left_out(verdict.json), expected)
            self.assertEqual(json.loads(wall_times_left_out(json.dumps(verdict))), json.loads(expected))
            self.assertEqual(verdict["verdict"], "agree")

    def test_a_seed_draws_other_states(self):
        """Detects a seed that is ignored."""
        model = MODELS / "compound_pendulum.toml"
        with tempfile.TemporaryDirectory() as folder:
            expected = by_program([model, "--until", "0.1", "--seed", "7"], folder)
        verdict = concord.compare(model, until=0.1, seed=7)
        self.assertEqual(wall_times_left_out(verdict.json), wall_times_left_out(expected))
        self.assertIn("perturbed with seed 7", verdict.table())
        resolvable = [[row["same_state_resolvable_digits"] for row in one["joints"]]
                      for one in (verdict, concord.compare(model, until=0.1))]
        self.assertNotEqual(*resolvable)

    def test_a_reference_is_judged(self):
        """Detects a reference that is not read, or is held against another model than the program's."""
        model = MODELS / "compound_pendulum.toml"
        with tempfile.TemporaryDirectory() as folder:
            off = pathlib.Path(folder) / "off.csv"
            off.write_text("# another program\n# error = 0.1 %\nt [s],hinge.child.F_x [N]\n0,12345\n")
            expected = by_program([model, "--until", "0.1", "--reference", off], folder, code=1)
            verdict = concord.compare(model, until=0.1, reference=off)
            self.assertEqual(wall_times_left_out(verdict.json), wall_times_left_out(expected))
            self.assertEqual(verdict["verdict"], "differ")
            with self.assertRaisesRegex(concord.InputError, "off.csv.*is no output time"):
                off.write_text("# error = 0.1 %\nt [s],hinge.child.F_x [N]\n0.0123,12345\n")
                concord.compare(model, until=0.1, reference=off)

    def test_a_chosen_integrator_runs(self):
        """Detects integrators that are exchanged or ignored."""
        verdict = concord.compare(MODELS / "compound_pendulum.toml", until=0.1, cartesian="ida")
        self.assertEqual(verdict.runs["cartesian"].integrator, "ida")
        with self.assertRaisesRegex(concord.InputError, "the relative solver has no integrator 'ida'"):
            concord.compare(MODELS / "compound_pendulum.toml", relative="ida")

    def test_what_is_out_of_range_is_refused_by_name(self):
        """Detects a call that takes what the command line refuses."""
        model = concord.load(MODELS / "compound_pendulum.toml")
        for arguments, words in (
            ({"until": -1.0}, "until must be a finite number above zero, found -1"),
            ({"until": float("nan")}, "until .* found nan"),
            ({"rtol": 1e-20}, "rtol must lie between 1e-14 and 0.01, found 1e-20"),
            ({"samples": 0}, "samples must lie between 1 and 1000000, found 0"),
        ):
            with self.assertRaisesRegex(concord.InputError, words):
                concord.compare(model, **arguments)
            with self.assertRaisesRegex(concord.InputError, words):
                concord.run(model, "relative", **arguments)
        with self.assertRaises(TypeError):
            concord.run(None, "relative")

    def test_a_verdict_survives_pickle(self):
        """Detects a verdict that cannot go to another process."""
        verdict = concord.compare(MODELS / "compound_pendulum.toml", until=0.05)
        self.assertEqual(pickle.loads(pickle.dumps(verdict)), dict(verdict))
        self.assertIn("passed", verdict.table())
        self.assertEqual((verdict.findings, verdict.failures), ([], []))


class Running(unittest.TestCase):
    def test_time_series_are_those_of_the_netcdf_file(self):
        """Detects arrays in another order than the files."""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # Debian's was compiled for another numpy
                import netCDF4
        except ImportError:
            self.skipTest("python3-netcdf4 is not installed")
        for model, is_redundant in (("slider_crank_flexible", False), ("slider_crank_redundant", True)):
            run = concord.run(MODELS / f"{model}.toml", "cartesian", until=0.01, samples=20)
            with tempfile.TemporaryDirectory() as folder:
                file = pathlib.Path(folder) / "run.nc"
                run.write_netcdf(file)
                with netCDF4.Dataset(file) as data:
                    names = [name for name, one in data.variables.items() if one.dtype == np.float64]
                    for name in names + ["unique"]:
                        expected = data.variables[name][...].filled(np.nan)
                        found = getattr(run, name)
                        found = found[:, 1:] if "body" in data.variables[name].dimensions else found
                        np.testing.assert_array_equal(found, expected, err_msg=name)
            self.assertGreater(len(names), 15)
            self.assertEqual("any_reaction" in names, is_redundant)
            self.assertEqual(np.isnan(run.reaction).any(), is_redundant)
            self.assertFalse(np.isnan(run.any_reaction).any())
            np.testing.assert_array_equal(run.reaction[run.unique], run.any_reaction[run.unique])

    def test_states_and_evaluations_are_those_of_the_series(self):
        """Detects views with wrong steps: a number is one and the same in a state or evaluation and in a series."""
        model = concord.load(MODELS / "car_flexible_beam.toml")
        run = concord.Solver(model, "relative").run(until=0.01, samples=4)
        state, found = run.state(-1), run.evaluation(4)
        self.assertEqual(state.time, run.time[-1])
        for name in ("position", "euler_parameters", "velocity", "angular_velocity"):
            np.testing.assert_array_equal(getattr(state, name), getattr(run, name)[-1], err_msg=name)
        for name in ("acceleration", "angular_acceleration", "reaction", "reaction_global", "total", "total_global",
                     "element_wrench", "element_wrench_global", "coupling_force"):
            np.testing.assert_array_equal(getattr(found, name), getattr(run, name)[-1], err_msg=name)
        for owner, names in ((state, ("modal_coordinates", "modal_velocities", "joint_coordinates", "joint_speeds")),
                             (found, ("modal_accelerations", "coordinate_force"))):
            for name in names:
                for k, row in enumerate(getattr(owner, name)):
                    np.testing.assert_array_equal(row, getattr(run, name)[-1, k, : len(row)], err_msg=name)
                    self.assertTrue(np.isnan(getattr(run, name)[-1, k, len(row) :]).all())
        # A wrench on a side: of equal size in both frames.
        size = np.linalg.norm(found.reaction[..., :3], axis=-1)
        np.testing.assert_allclose(size, np.linalg.norm(found.reaction_global[..., :3], axis=-1), rtol=1e-12)
        with self.assertRaises(IndexError):
            run.state(5)

    def test_times_are_equal_steps_from_zero(self):
        """Detects a run on another grid than the one asked for."""
        solver = concord.Solver(concord.load(MODELS / "compound_pendulum.toml"), "cartesian")
        times = np.linspace(0, 0.3, 7)
        np.testing.assert_allclose(solver.run(times).time, times, rtol=1e-15)
        for wrong in ([0, 0.1, 0.3], [0.1, 0.2], [0.0], [0, 0]):
            with self.assertRaises(concord.InputError):
                solver.run(wrong)

    def test_a_run_from_a_state_starts_there(self):
        """Detects a start that is ignored, and one that is not closed."""
        model = concord.load(MODELS / "compound_pendulum.toml")
        solver = concord.Solver(model, "relative")
        state = solver.run(until=0.2, samples=2).state(2)
        with self.assertRaisesRegex(concord.InputError, "a run starts at time 0, the state is of 0.2 s"):
            solver.run(until=0.1, start=state)
        state.time = 0.0
        np.testing.assert_allclose(solver.run(until=0.1, start=state).position[0], state.position, atol=1e-14)

    def test_a_singular_pose_ends_a_run(self):
        """Detects an exception of another kind where a solver cannot go on, and a run that is returned all the same."""
        flat = concord.load(MODELS / "slider_crank_rigid.toml", parameters={"r": 0.3})
        for name in ("cartesian", "relative"):
            with self.assertRaisesRegex(concord.SolverError, f"^{name}: at t = 0.01.* singular") as caught:
                concord.run(flat, name, until=0.1)
            self.assertIsInstance(caught.exception, concord.SingularPose)
        verdict = concord.compare(flat, until=0.1)
        self.assertEqual(verdict["verdict"], "failed")
        self.assertRegex("\n".join(verdict.failures), "singular")
        self.assertEqual(verdict.runs, {"cartesian": None, "relative": None})


if __name__ == "__main__":
    unittest.main(verbosity=2)
