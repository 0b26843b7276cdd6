"""OSQP at tolerance 1e-6, warm-started, timed by its own clock: what its C code takes, without Python."""

import sys

import numpy as np
import osqp
from scipy import sparse


def main(source, target):
    table = np.fromfile(source)
    rows = table[1:].reshape(-1, int(table[0]))
    n, m = int(rows[0, 0]), int(rows[0, 1])
    sizes = np.cumsum([n * n, n, m * n, m, m, n])
    solver, answers = None, []
    # The pattern of non-zeros must not change: all entries of the triangle and of A are stored.
    upper_rows, upper_columns = np.triu_indices(n)
    order = np.lexsort((upper_rows, upper_columns))
    upper_rows, upper_columns = upper_rows[order], upper_columns[order]
    for row in rows:
        hessian, gradient, matrix, row_lower, row_upper, lower, upper = np.split(row[2:], sizes)
        hessian = hessian.reshape(n, n)[upper_rows, upper_columns]
        dense = np.vstack([matrix.reshape(m, n), np.eye(n)])
        low, high = np.concatenate([row_lower, lower]), np.concatenate([row_upper, upper])
        if solver is None:
            starts = np.concatenate([[0], np.cumsum(np.arange(1, n + 1))])
            columns = np.tile(np.arange(m + n), n)
            pattern = (dense.T.ravel(), columns, (m + n) * np.arange(n + 1))
            solver = osqp.OSQP()
            solver.setup(
                sparse.csc_matrix((hessian, upper_rows, starts), shape=(n, n)), gradient,
                sparse.csc_matrix(pattern, shape=(m + n, n)), low, high,
                eps_abs=1e-6, eps_rel=1e-6, verbose=False,
            )
            result = solver.solve()
            time = result.info.setup_time + result.info.solve_time
        else:
            solver.update(q=gradient, l=low, u=high, Px=hessian, Ax=dense.T.ravel())
            result = solver.solve()
            time = result.info.update_time + result.info.solve_time
        solved = result.info.status == "solved"
        answers.append(np.concatenate([[time * 1e6, solved, result.info.iter], result.x]))
    np.concatenate([[3.0 + n], np.ravel(answers)]).tofile(target)


main(*sys.argv[1:])
