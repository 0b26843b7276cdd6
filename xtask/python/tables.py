"""Reads the files that legwork writes with other people's libraries: names, types, rows, and values to the last bit.

Takes the path of the program; what it writes goes into a folder for temporary files.
"""

import csv
import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

import duckdb
import pandas
import polars
import pyarrow.csv
import pyarrow.dataset
import pyarrow.json
import pyarrow.parquet

LEGWORK = pathlib.Path(sys.argv.pop(1)).resolve()

WALK = 'extends = "walk"\nname = "short"\nduration_s = 0.2\n'
STUDY = """
scenarios = ["short.toml"]
design = "one-at-a-time"
[[factors]]
path = "controller.form"
list = ["direct", "slack"]
[[factors]]
path = "ground.friction"
list = [1, 0.5]
[[factors]]
path = "ground.known"
list = [true, false]
"""
SENSITIVITY = """
scenarios = ["short.toml"]
design = "saltelli"
samples = 4
[[factors]]
path = "ground.friction"
linear = { from = 0.5, to = 1.0 }
[[factors]]
path = "controller.weights.feet"
logarithmic = { from = 1e4, to = 1e6 }
"""
TUNING = """
budget = 6
[[factors]]
name = "CoM gain, a factor"
path = "controller.planner.com_gain"
logarithmic = { from = 500, to = 5000 }
[[cases]]
name = "a, \\"short\\" walk"
scenario = "short.toml"
[[held_out]]
name = "fast"
scenario = "short.toml"
set.reference.com.speed_mps = 0.55
[[objective]]
metric = "torque_nm.mean"
"""

# Columns of whole numbers, and those that hold texts; all others hold doubles.
COUNTS = {"rollouts", "ticks", "evaluations", "feasible", "doubtful"}
FLAG = {"true": True, "false": False}
TEXTS = {
    "scenario", "ending", "cause", "reason", "violations", "input_hash", "result_hash", "controller.form",
    "question", "unit", "reason_beyond", "joint", "coping", "set", "case", "design",
}
FLAGS = {"ground.known"}

FOLDER = None
RUNS = ["walk", "feet-walk", "exo-sway"]


def legwork(*arguments):
    """Runs the program in the folder; what it prints."""
    done = subprocess.run([LEGWORK, *arguments], cwd=FOLDER, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    assert done.returncode == 0, f"legwork {arguments}: {done.stderr}"
    return done.stdout


def setUpModule():
    global FOLDER
    temporary = tempfile.TemporaryDirectory(prefix="legwork-tables-")
    unittest.addModuleCleanup(temporary.cleanup)
    FOLDER = pathlib.Path(temporary.name)
    texts = {"short.toml": WALK, "study.toml": STUDY, "sensitivity.toml": SENSITIVITY, "tuning.toml": TUNING}
    for name, text in texts.items():
        (FOLDER / name).write_text(text)
    for ending in ["csv", "parquet"]:
        lines = legwork("run", *RUNS, "--duration", "0.2", "--log", f"log.{ending}", "--json")
        (FOLDER / "runs.jsonl").write_text(lines)
    legwork("study", "study.toml", "--out", "study")
    legwork("study", "sensitivity.toml", "--out", "sensitivity")
    legwork("tune", "tuning.toml", "--out", "tuning")
    legwork("limits", "--quick", "--set", "duration_s=0.6", "--out", "limits")


def bits(values):
    """The values of a column: doubles as their bits, nothing as nothing, so that equal means the same to the last bit."""
    plain = [None if value is None or value != value else value for value in values]
    return [struct.pack("<d", value) if isinstance(value, float) else value for value in plain]


def kind(values):
    """The type that all values of a column have; none of an empty column."""
    kinds = {type(value) for value in values if value is not None and value == value}
    assert len(kinds) < 2, f"values of several types: {kinds}"
    return kinds.pop() if kinds else None


# Each reads a table: its columns by name, with the values as Python has them.
def by_pandas(frame):
    return {name: [None if pandas.isna(value) else value for value in frame[name].tolist()] for name in frame.columns}


def by_fastparquet(path):
    columns = by_pandas(pandas.read_parquet(path, engine="fastparquet"))
    # It has 1.0 and 0.0 for flags with empty cells among them.
    flags = {name: [None if flag is None else bool(flag) for flag in columns[name]] for name in FLAGS & columns.keys()}
    return columns | flags


def by_duckdb(query, path):
    table = duckdb.sql(query.format(path=path))
    return dict(zip(table.columns, map(list, zip(*table.fetchall()))))


CSV = {
    "pandas": lambda path: by_pandas(pandas.read_csv(path)),
    "pandas with pyarrow": lambda path: by_pandas(pandas.read_csv(path, engine="pyarrow", dtype_backend="pyarrow")),
    "pyarrow.csv": lambda path: pyarrow.csv.read_csv(path, convert_options=NULLS).to_pydict(),
    "polars": lambda path: polars.read_csv(path).to_dict(as_series=False),
    "duckdb": lambda path: by_duckdb("from read_csv('{path}')", path),
}
NULLS = pyarrow.csv.ConvertOptions(strings_can_be_null=True)
PARQUET = {
    "pandas with pyarrow": lambda path: by_pandas(pandas.read_parquet(path, engine="pyarrow")),
    "pandas with fastparquet": lambda path: by_fastparquet(path),
    "pyarrow.parquet": lambda path: pyarrow.parquet.read_table(path).to_pydict(),
    "pyarrow.dataset": lambda path: pyarrow.dataset.dataset(path).to_table().to_pydict(),
    "polars": lambda path: polars.read_parquet(path).to_dict(as_series=False),
    "duckdb": lambda path: by_duckdb("from read_parquet('{path}')", path),
}


def with_units(path):
    """The names of a Parquet file's columns as the head of a CSV file has them."""
    schema = pyarrow.parquet.read_schema(path)
    units = {key.decode(): value.decode() for key, value in schema.metadata.items()}
    return [f"{name} [{units['unit:' + name]}]" if "unit:" + name in units else name for name in schema.names]


def expected(path):
    """The columns of a CSV file by the words in it, which are declared to be texts, whole numbers or doubles."""
    with open(path, newline="") as file:
        head, *rows = csv.reader(file)
    assert len(set(head)) == len(head), "names that stand twice"
    columns = {}
    for name, cells in zip(head, zip(*rows)):
        bare = name.split(" [")[0]
        read = str if bare in TEXTS else int if bare in COUNTS else FLAG.get if bare in FLAGS else float
        columns[name] = [None if cell == "" else read(cell) for cell in cells]
    return columns


class Tables(unittest.TestCase):
    def check(self, readers, path, columns):
        """Every library finds these columns in the file."""
        for library, read in readers.items():
            with self.subTest(library=library, file=path.name):
                found = read(str(path))
                self.assertEqual(list(found), list(columns))
                for name, values in columns.items():
                    # Without a value a column of a CSV file has no type.
                    self.assertEqual(kind(found[name]), kind(values), name)
                    self.assertEqual(bits(found[name]), bits(values), name)

    def check_both(self, stem, rows):
        """A table that is there as CSV and as Parquet."""
        table, parquet = stem.with_suffix(".csv"), stem.with_suffix(".parquet")
        columns = expected(table)
        self.assertEqual(len(next(iter(columns.values()))), rows)
        self.check(CSV, table, columns)
        self.assertEqual(with_units(parquet), list(columns))
        names = pyarrow.parquet.read_schema(parquet).names
        self.check(PARQUET, parquet, dict(zip(names, columns.values())))
        for field in pyarrow.parquet.read_schema(parquet):
            declared = "string" if field.name in TEXTS else "bool" if field.name in FLAGS else "double"
            self.assertEqual(str(field.type), declared, field.name)

    def test_logs(self):
        for run in RUNS:
            self.check_both(FOLDER / f"log-{run}", 200)

    def test_a_log_has_the_coordinates_that_the_model_has(self):
        model = json.loads(legwork("inspect", "exo18", "--json"))
        names = pyarrow.parquet.read_schema(FOLDER / "log-exo-sway.parquet").names
        coordinates = [f"q.{name}" for name in model["q_names"]] + [f"v.{name}" for name in model["v_names"]]
        self.assertEqual(names[: 1 + len(coordinates)], ["t", *coordinates])

    def test_rollouts(self):
        # The scenario as it stands, and each level.
        self.check_both(FOLDER / "study/rollouts", 1 + 6)
        self.check_both(FOLDER / "sensitivity/rollouts", 4 * (2 * 2 + 2))

    def test_rollouts_have_every_metric(self):
        metrics = json.loads(legwork("list", "metrics", "--json"))["metrics"]
        names = [name.split(".")[0] for name in pyarrow.parquet.read_schema(FOLDER / "study/rollouts.parquet").names]
        self.assertEqual([metric["name"] for metric in metrics if metric["name"] not in names], [])

    def test_tables_of_a_tuning(self):
        self.check(CSV, FOLDER / "tuning/history.csv", expected(FOLDER / "tuning/history.csv"))
        self.check(CSV, FOLDER / "tuning/cases.csv", expected(FOLDER / "tuning/cases.csv"))

    def test_tables_of_limits(self):
        tables = sorted((FOLDER / "limits").glob("*.csv"))
        names = ["limits", "robustness", "sizing", "speed_torque_map", "torque_speed"]
        self.assertEqual([table.stem for table in tables], names)
        for table in tables:
            self.check(CSV, table, expected(table))

    def test_lines_of_json(self):
        path = FOLDER / "runs.jsonl"
        runs = [json.loads(line) for line in path.read_text().splitlines()]
        readers = {
            "pandas": lambda: pandas.read_json(path, lines=True, precise_float=True).to_dict("records"),
            "pyarrow.json": lambda: pyarrow.json.read_json(path).to_pylist(),
            "polars": lambda: polars.read_ndjson(path).to_dicts(),
            "duckdb": lambda: by_rows(duckdb.sql(f"from read_json('{path}')")),
        }
        for library, read in readers.items():
            with self.subTest(library=library):
                found = read()
                self.assertEqual(len(found), len(RUNS))
                for run, there in zip(runs, found):
                    self.assertEqual(list(there), list(run))
                    for key in ["scenario", "outcome", "input_hash", "result_hash"]:
                        self.assertEqual(there[key], run[key])
                    for metric in ["grf_n", "torque_nm"]:
                        means = [there["metrics"][metric]["mean"], run["metrics"][metric]["mean"]]
                        self.assertEqual(bits(means)[0], bits(means)[1], metric)

    def test_results_in_json(self):
        for name in ["study", "sensitivity", "tuning"]:
            path = FOLDER / name / "results.json"
            result = json.loads(path.read_text())
            readers = {
                "pandas": lambda: list(pandas.json_normalize(result, max_level=0).columns),
                "polars": lambda: polars.read_json(path).columns,
                "duckdb": lambda: duckdb.sql(f"from read_json('{path}')").columns,
            }
            for library, read in readers.items():
                with self.subTest(library=library, file=name):
                    self.assertEqual(read(), list(result))


def by_rows(table):
    return [dict(zip(table.columns, row)) for row in table.fetchall()]


if __name__ == "__main__":
    program = unittest.main(exit=False)
    failed = len({getattr(test, "test_case", test).id() for test, _ in program.result.failures + program.result.errors})
    passed = max(program.result.testsRun - failed, 0)
    print(f"test result: {passed} passed; {failed} failed")
    sys.exit(0 if failed == 0 and passed else 1)
