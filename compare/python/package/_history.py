"""The nightly history as tables of pandas."""

import contextlib
import os
import pathlib
import sqlite3
import typing

from . import _native

_APPLICATION = 0x636F6E63  # "conc", as in compare/nightly/history.cpp


class History(typing.NamedTuple):
    """Tables of pandas, one row for each night, each case of a night, and each component of such a case."""

    nights: typing.Any
    results: typing.Any
    components: typing.Any


def history(file):
    """Reads the file that `concord nightly --history` writes; `concord nightly` may be writing it."""
    try:
        import pandas
    except ImportError as error:
        raise ImportError("concord.history needs pandas (Debian: python3-pandas)") from error
    name = os.fspath(file)
    if not os.path.isfile(name):
        raise _input_error(name, "cannot be read: there is no such file")
    try:
        with contextlib.closing(sqlite3.connect(_uri(name), uri=True)) as database:
            database.execute("PRAGMA query_only = TRUE")
            _require_format(name, database)
            database.execute("BEGIN")  # all tables as they are at one moment
            return _read(pandas, database)
    except (sqlite3.Error, pandas.errors.DatabaseError) as error:
        raise _input_error(name, f"cannot be read: {error}") from error


def _uri(name):
    """How SQLite opens the file so that nothing is left beside it: the files of its log are removed only by who may
    write; without them it reads as if nobody wrote, unless somebody does."""
    path = pathlib.Path(name).resolve()
    if os.access(path, os.W_OK) and os.access(path.parent, os.W_OK):
        return path.as_uri() + "?mode=rw"
    log = path.with_name(path.name + "-wal")
    is_written = log.is_file() and log.stat().st_size > 0
    return path.as_uri() + ("?mode=ro" if is_written else "?immutable=1")


def _require_format(name, database):
    application = database.execute("PRAGMA application_id").fetchone()[0]
    if application != _APPLICATION:
        raise _input_error(name, "is no history: it is a SQLite file of another program")
    found = database.execute("PRAGMA user_version").fetchone()[0]
    known = _native.history_format
    if found == known:
        return
    remedy = "`concord history` brings the file up to date" if found < known else "a later concord wrote it"
    raise _input_error(name, f"version {found} of the history is not known: this reads version {known}; {remedy}")


def _read(pandas, database):
    nights = pandas.read_sql_query(
        "SELECT * FROM night ORDER BY id", database, index_col="id", parse_dates=["started", "finished"]
    )
    results = pandas.read_sql_query("SELECT * FROM result ORDER BY night, name", database, index_col="id")
    components = pandas.read_sql_query(
        'SELECT result.night, result.name AS "case", component.*, component.name AS component FROM component'
        ' JOIN result ON result.id = component.result ORDER BY result.night, "case", component',
        database,
    )
    return History(
        nights, results.rename(columns={"name": "case"}), components.drop(columns=["name"]).reset_index(drop=True)
    )


def _input_error(file, message):
    error = _native.InputError(f"{file}: error: {message}")
    error.diagnostics = [_native.Diagnostic(file, 0, 0, message)]
    return error
