# %% [markdown]
# # A machine by two solvers
# Run it cell by cell in an editor that knows `# %%`, or at once: `compare/python/run compare/python/example.py`.

# %% Load
import pathlib
import sys
import tempfile

import concord
import numpy as np

here = pathlib.Path(__file__).resolve().parent
models = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else here.parents[1] / "data" / "models"
model = concord.load(models / "slider_crank_flexible.toml")
print(model)
print("joints:", ", ".join(f"{joint} ({kind})" for joint, kind in zip(model.joints, model.joint_types)))

# %% Compare
verdict = concord.compare(model, until=0.2)
print(verdict["verdict"], "-", verdict["judged"], "of", verdict["total"], "components judged")
print("worst digits:", {check: verdict[check]["digits"] for check in ("same_state", "same_run", "refined", "audit")})

# %% The components nearest to the digits that they must reach
judged = [row for row in verdict["joints"] if row["verdict"] != "not_judged"]
judged.sort(key=lambda row: row["same_run_digits"] - row["need"]["same_run"])
print(f"{'joint':6}{'side':8}{'component':10}{'same state':>11}{'same run':>10}{'refined':>9}")
for row in judged[:5]:
    print(
        f"{row['joint']:6}{row['side']:8}{row['component']:10}"
        f"{row['same_state_digits']:11.2f}{row['same_run_digits']:10.2f}{row['refined_digits']:9.2f}"
    )

# %% Where along the run do the two differ most?
runs = verdict.runs
difference = np.abs(runs["cartesian"].reaction - runs["relative"].reaction).max(axis=(2, 3))
for k, joint in enumerate(model.joints):
    worst = difference[:, k].argmax()
    print(f"joint {joint}: {difference[worst, k]:.1e} N, N m at t = {runs['cartesian'].time[worst]:.3f} s")

# %% One state, both solvers
state = runs["relative"].state(40)
found = {name: concord.Solver(model, name).evaluate(state, uniqueness=True) for name in ("cartesian", "relative")}
difference = np.abs(found["cartesian"].reaction - found["relative"].reaction)
unique = found["cartesian"].rank.unique & found["relative"].rank.unique
print(f"largest difference at t = {state.time:.3f} s: {difference[unique].max():.1e} N, N m")

# %% The same machine with another parameter
stiffer = concord.load(models / "slider_crank_rigid.toml", parameters={"d_coupler": 0.008})
solver = concord.Solver(stiffer, "relative")
peak = np.abs(solver.run(np.linspace(0.0, 0.2, 101)).reaction).max(axis=(0, 2, 3))
print("peaks:", dict(zip(stiffer.joints, peak.round(3))))

# %% Results by xarray, where it is installed (Debian: python3-xarray, python3-netcdf4)
try:
    import xarray
except ImportError:
    print("xarray: not installed")
else:
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "cartesian.nc"
        runs["cartesian"].write_netcdf(file)
        with xarray.open_dataset(file) as data:
            print(abs(data.reaction).max("time").sel(side="child").to_pandas().round(3))
