"""Makes salib.json: what SALib and SciPy say about samples that tests/salib.rs gives to legwork.

python -m venv venv && venv/bin/pip install SALib==1.6.0 numpy==2.4.6 scipy==1.17.1
venv/bin/python crates/legwork-study/tests/data/salib.py > crates/legwork-study/tests/data/salib.json
"""

import json
from importlib.metadata import version

import numpy as np
from SALib.analyze import morris as morris_analysis
from SALib.analyze import sobol as sobol_analysis
from SALib.sample import morris as morris_sample
from SALib.sample import sobol as sobol_sample
from scipy.stats import qmc

CUBE = {"num_vars": 3, "names": ["x1", "x2", "x3"], "bounds": [[0.0, 1.0]] * 3}


def ishigami(points):
    x = np.pi * (2 * points - 1)
    return np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


def sobol(second_order):
    points = sobol_sample.sample(CUBE, 16, calc_second_order=second_order, seed=1)
    outputs = ishigami(points)
    found = sobol_analysis.analyze(CUBE, outputs, calc_second_order=second_order, seed=1)
    result = {"points": points.tolist(), "outputs": outputs.tolist()}
    result |= {"S1": found["S1"].tolist(), "ST": found["ST"].tolist()}
    if second_order:
        result["S2"] = [[i, j, found["S2"][i, j]] for i in range(3) for j in range(i + 1, 3)]
    return result


def morris(levels):
    points = morris_sample.sample(CUBE, 12, num_levels=levels, seed=1)
    outputs = ishigami(points)
    found = morris_analysis.analyze(CUBE, points, outputs, num_levels=levels, seed=1)
    result = {"points": points.tolist(), "outputs": outputs.tolist()}
    return result | {key: np.asarray(found[key]).tolist() for key in ["mu", "mu_star", "sigma"]}


def sequence():
    rows = []
    for index in [2**k for k in range(11)] + [12345, 987654321]:
        point = qmc.Sobol(d=64, scramble=False, bits=32).fast_forward(index).random(1)[0]
        rows.append({"index": index, "point": point.tolist()})
    return rows


print(
    json.dumps(
        {
            "made_with": {name: version(name) for name in ["SALib", "numpy", "scipy"]},
            "sobol": sobol(second_order=False),
            "sobol_second_order": sobol(second_order=True),
            "morris": [morris(4), morris(6)],
            "sobol_sequence": sequence(),
        }
    )
)
