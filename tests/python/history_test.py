"""The nightly history by the Python module, and its stub.

Each test says which mistake it detects.
"""

import ast
import os
import pathlib
import sqlite3
import subprocess
import tempfile
import unittest

import concord

PROGRAM = os.environ["CONCORD_PROGRAM"]
MODELS = pathlib.Path(os.environ["CONCORD_DATA"]) / "models"


class Nights(unittest.TestCase):
    def setUp(self):
        try:
            import pandas  # noqa: F401
        except ImportError:
            self.skipTest("python3-pandas is not installed")
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.file = pathlib.Path(self.folder.name) / "nights.sqlite"
        suite = pathlib.Path(self.folder.name) / "suite.toml"
        model = (MODELS / "compound_pendulum.toml").resolve()
        suite.write_text(f"format = 1\n[[case]]\nmodels = ['{model}']\nuntil = 0.1\n", encoding="utf-8")
        done = subprocess.run([PROGRAM, "nightly", suite, "--history", self.file], capture_output=True)
        self.assertEqual(done.returncode, 4, done.stderr)  # no baseline yet

    def change(self, statement):
        database = sqlite3.connect(self.file)
        database.execute(statement)
        database.commit()
        database.close()

    def test_history_is_read(self):
        """Detects tables that do not belong together."""
        history = concord.history(self.file)
        self.assertEqual(len(history.nights), 1)
        self.assertEqual(list(history.results["case"]), ["compound_pendulum"])
        self.assertEqual(history.results["ending"].iloc[0], "agree")
        self.assertEqual(history.nights.index[0], history.results["night"].iloc[0])
        self.assertEqual(set(history.components["case"]), {"compound_pendulum"})
        self.assertGreater(history.components["same_state"].min(), 12)
        self.assertEqual(str(history.nights["started"].dtype), "datetime64[ns]")

    def test_nothing_is_left_beside_the_file(self):
        """Detects the files of SQLite's log, and a reader that changes the history."""
        before = sorted(os.listdir(self.folder.name))
        content = self.file.read_bytes()
        concord.history(self.file)
        self.assertEqual(sorted(os.listdir(self.folder.name)), before)
        self.assertEqual(self.file.read_bytes(), content)

    def test_another_version_is_refused_by_name(self):
        """Detects a file of another layout that is read all the same."""
        for version in (1, 999):
            self.change(f"PRAGMA user_version = {version}")
            with self.assertRaisesRegex(concord.InputError, f"version {version} of the history is not known"):
                concord.history(self.file)

    def test_what_is_no_history_is_refused(self):
        """Detects an error of SQLite that reaches the user bare."""
        with self.assertRaisesRegex(concord.InputError, "no such file"):
            concord.history(self.file.with_name("other.sqlite"))
        self.change("PRAGMA application_id = 5")
        with self.assertRaisesRegex(concord.InputError, "SQLite file of another program"):
            concord.history(self.file)
        text = self.file.with_name("text.sqlite")
        text.write_text("this is no database, and it is longer than the head of one " * 20, encoding="utf-8")
        with self.assertRaisesRegex(concord.InputError, "text.sqlite: error: cannot be read"):
            concord.history(text)

    def test_a_damaged_history_is_refused(self):
        """Detects an error of pandas that reaches the user bare."""
        self.change("DROP TABLE component")
        with self.assertRaisesRegex(concord.InputError, "error: cannot be read: .*no such table"):
            concord.history(self.file)


class Stub(unittest.TestCase):
    def test_the_stub_names_what_there_is(self):
        """Detects a stub that is behind the module."""
        stub = ast.parse(pathlib.Path(concord.__file__).with_name("__init__.pyi").read_text(encoding="utf-8"))
        stated = {node.name: node for node in stub.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
        self.assertEqual(sorted(stated), sorted(concord.__all__))
        for name, node in stated.items():
            if not isinstance(node, ast.ClassDef) or name == "History" or name == "Diagnostic":
                continue
            members = {one.name for one in node.body if isinstance(one, ast.FunctionDef)}
            members |= {one.target.id for one in node.body if isinstance(one, ast.AnnAssign)}
            there = {one for one in vars(getattr(concord, name)) if not one.startswith("_")}
            self.assertEqual({one for one in members if not one.startswith("_")}, there, name)


if __name__ == "__main__":
    unittest.main(verbosity=2)
