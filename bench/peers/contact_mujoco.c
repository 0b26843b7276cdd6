// MuJoCo's step from recorded states, with the recorded torques: state set, then one timed mj_step.
#include <math.h>
#include <mujoco/mujoco.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static double now_us(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return 1e6 * (double)t.tv_sec + 1e-3 * (double)t.tv_nsec;
}

// R(q) a for a quaternion (w, x, y, z), or its transpose.
static void rotate(const double* q, const double* a, int transpose, double* out) {
  mjtNum inverse[4];
  if (transpose) {
    mju_negQuat(inverse, q);
    mju_rotVecQuat(out, a, inverse);
  } else {
    mju_rotVecQuat(out, a, q);
  }
}

int main(int argc, char** argv) {
  if (argc < 4) return 2;
  char error[1000] = "";
  mjModel* model = mj_loadXML(argv[1], NULL, error, sizeof error);
  if (!model) {
    fprintf(stderr, "%s\n", error);
    return 1;
  }
  mjData* data = mj_makeData(model);
  FILE* in = fopen(argv[2], "rb");
  FILE* out = fopen(argv[3], "wb");
  double columns = 0;
  if (!in || !out || fread(&columns, 8, 1, in) != 1) return 1;
  const int nq = model->nq, nv = model->nv, nu = model->nu, floating = nq != nv;
  double* row = malloc(sizeof(double) * (size_t)columns);
  double* v = malloc(sizeof(double) * (size_t)nv);
  const double width = 3 + nv;
  fwrite(&width, 8, 1, out);
  // The first rows run twice, to warm caches.
  for (int pass = 0; pass < 2; ++pass) {
    fseek(in, 8, SEEK_SET);
    mj_resetData(model, data);
    for (int i = 0; pass || i < 200; ++i) {
      if (fread(row, 8, (size_t)columns, in) != (size_t)columns) break;
      const double *q_in = row + nu, *v_in = q_in + nq;
      memcpy(data->ctrl, row, sizeof(double) * (size_t)nu);
      if (floating) {
        // Recorded: quaternion, position; angular and linear velocity in body axes. MuJoCo: position, quaternion; linear
        // velocity in world axes, angular in body axes.
        memcpy(data->qpos, q_in + 4, 3 * sizeof(double));
        memcpy(data->qpos + 3, q_in, 4 * sizeof(double));
        memcpy(data->qpos + 7, q_in + 7, sizeof(double) * (size_t)(nq - 7));
        rotate(q_in, v_in + 3, 0, data->qvel);
        memcpy(data->qvel + 3, v_in, 3 * sizeof(double));
        memcpy(data->qvel + 6, v_in + 6, sizeof(double) * (size_t)(nv - 6));
      } else {
        memcpy(data->qpos, q_in, sizeof(double) * (size_t)nq);
        memcpy(data->qvel, v_in, sizeof(double) * (size_t)nv);
      }
      const double begin = now_us();
      mj_step(model, data);
      const double time = now_us() - begin;
      if (!pass) continue;
      if (floating) {
        memcpy(v, data->qvel + 3, 3 * sizeof(double));
        rotate(data->qpos + 3, data->qvel, 1, v + 3);
        memcpy(v + 6, data->qvel + 6, sizeof(double) * (size_t)(nv - 6));
      } else {
        memcpy(v, data->qvel, sizeof(double) * (size_t)nv);
      }
      const double head[3] = {time, isfinite(v[0]) ? 1.0 : 0.0, (double)data->solver_niter[0]};
      fwrite(head, 8, 3, out);
      fwrite(v, 8, (size_t)nv, out);
    }
  }
  fclose(out);
  return 0;
}
