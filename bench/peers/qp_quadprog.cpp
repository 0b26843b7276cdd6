// quadprog's C code, which has no warm start.
#include "qp_programs.hpp"

extern "C" int qpgen2_(double* G, double* av, int n, double* xv, double* lagr, double* obj, double* C, double* bv, int q,
                       int meq, int* iact, int* nact, int* iter, double* work, int factorized);

int main(int, char** argv) {
  run(argv[1], argv[2], [&](const Program& p, Table& out) {
    const Split split(p);
    const int equalities = int(split.E.rows()), q = equalities + int(split.G.rows()), r = std::min(p.n, q);
    Matrix C(p.n, q);
    C << split.E.transpose(), split.G.transpose();
    Vector b(q), x(p.n), lagrange(q), work(2 * p.n + 2 * q + r * (r + 5) / 2 + 10 + p.n);
    b << split.e, split.b;
    std::vector<int> active(std::size_t(q) + 1);
    double objective = 0;
    int count = 0, iterations[2] = {0, 0};
    Matrix G = p.H;
    Vector a = -p.g;
    const Clock clock;
    const int status = qpgen2_(G.data(), a.data(), p.n, x.data(), lagrange.data(), &objective, C.data(), b.data(), q,
                               equalities, active.data(), &count, iterations, work.data(), 0);
    const double time = clock.microseconds();
    answer(out, time, status == 0, iterations[0], x);
  });
}
