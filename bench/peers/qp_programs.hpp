// The programs, and the form "equalities; inequalities G x >= b; bounds" that several solvers want.
#pragma once

#include <cmath>

#include <Eigen/Dense>

#include "table.hpp"

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic>;
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Vector = Eigen::VectorXd;

struct Program {
  int n, m;
  Matrix H;
  Vector g;
  RowMatrix A;
  Vector row_lower, row_upper, lower, upper;

  explicit Program(const double* at) : n(int(at[0])), m(int(at[1])) {
    at += 2;
    auto vector = [&](int count) {
      Vector values = Eigen::Map<const Vector>(at, count);
      at += count;
      return values;
    };
    H = Eigen::Map<const RowMatrix>(at, n, n);
    at += n * n;
    g = vector(n);
    A = Eigen::Map<const RowMatrix>(at, m, n);
    at += m * n;
    row_lower = vector(m);
    row_upper = vector(m);
    lower = vector(n);
    upper = vector(n);
  }
};

inline std::vector<Program> read_programs(const char* path) {
  const Table table = Table::read(path);
  std::vector<Program> programs;
  for (std::size_t i = 0; i < table.rows(); ++i) programs.emplace_back(table.row(i));
  return programs;
}

// E x = e and G x >= b, with bounds as rows. Rows without any bound and rows of zeros are left out.
struct Split {
  RowMatrix E, G;
  Vector e, b;

  explicit Split(const Program& p, bool with_bounds = true) {
    std::vector<std::pair<Vector, double>> equal, above;
    auto add = [&](const Vector& row, double lower, double upper) {
      if (row.isZero(0.0)) return;
      if (lower >= upper) {
        equal.emplace_back(row, upper);
        return;
      }
      if (std::isfinite(lower)) above.emplace_back(row, lower);
      if (std::isfinite(upper)) above.emplace_back(-row, -upper);
    };
    for (int i = 0; i < p.m; ++i) add(p.A.row(i).transpose(), p.row_lower[i], p.row_upper[i]);
    if (with_bounds)
      for (int j = 0; j < p.n; ++j) add(Vector::Unit(p.n, j), p.lower[j], p.upper[j]);
    auto stack = [&](const auto& rows, RowMatrix& matrix, Vector& values) {
      matrix.resize(Eigen::Index(rows.size()), p.n);
      values.resize(Eigen::Index(rows.size()));
      for (std::size_t i = 0; i < rows.size(); ++i) {
        matrix.row(Eigen::Index(i)) = rows[i].first.transpose();
        values[Eigen::Index(i)] = rows[i].second;
      }
    };
    stack(equal, E, e);
    stack(above, G, b);
  }
};

// A x = b and l <= C x <= u, bounds apart. Rows of zeros are left out.
struct TwoSided {
  Matrix A, C;
  Vector b, l, u;

  explicit TwoSided(const Program& p) {
    std::vector<int> equal, other;
    for (int i = 0; i < p.m; ++i) {
      if (p.A.row(i).isZero(0.0)) continue;
      (p.row_lower[i] >= p.row_upper[i] ? equal : other).push_back(i);
    }
    A = p.A(equal, Eigen::all);
    b = p.row_upper(equal);
    C = p.A(other, Eigen::all);
    l = p.row_lower(other);
    u = p.row_upper(other);
  }
};

// Runs `solve(program, out)`, which appends one answer, over all programs; the first ones twice, to warm caches.
template <typename Solve>
void run(const char* input, const char* output, Solve&& solve) {
  const auto programs = read_programs(input);
  Table out;
  out.columns = 3 + std::size_t(programs.at(0).n);
  for (std::size_t i = 0; i < 20 && i < programs.size(); ++i) solve(programs[i], out);
  out.values.clear();
  for (const auto& program : programs) solve(program, out);
  out.write(output);
}

inline void answer(Table& out, double time, bool solved, double iterations, const Vector& x) {
  out.begin_answer(time, solved, iterations);
  out.values.insert(out.values.end(), x.data(), x.data() + x.size());
}
