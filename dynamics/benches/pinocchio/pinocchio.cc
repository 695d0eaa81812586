// Times Pinocchio's rnea and crba on a tree and states that `cargo bench -p dynamics --bench rnea`
// dumped, and compares their results with ours. Arguments: model.txt states.bin. One JSON line.
//
// Ours to Pinocchio's, for each free and ball joint with rotation R (zero frame from link):
//   velocities: ours along the zero frame, Pinocchio's along the link: v_p = Rᵀ v
//   free acceleration: Pinocchio's is the rate of its components, a_p = Rᵀ a − (Rᵀω) × (Rᵀv)
//   forces: τ_p = Rᵀ τ;   mass matrix: M = Aᵀ M_p A with A = blockdiag(Rᵀ)
//   quaternions: ours w x y z, Pinocchio's x y z w
#include <pinocchio/multibody.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <string>
#include <vector>

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
namespace pin = pinocchio;

// CPU time of this thread: other jobs on the machine do not count.
static double now() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}

struct Joint { std::string type; int q, v; };

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  std::ifstream in(argv[1]);
  int bodies, nq, nv, states;
  Vector3d gravity;
  in >> bodies >> nq >> nv >> states >> gravity[0] >> gravity[1] >> gravity[2];
  pin::Model model;
  model.gravity.linear() = gravity;
  std::vector<Joint> joints;
  std::vector<pin::JointIndex> index;
  for (int i = 0, q = 0, v = 0; i < bodies; i++) {
    int parent;
    std::string type;
    Vector3d axis, p, com;
    Matrix3d r, inertia;
    double mass;
    in >> parent >> type;
    for (int k = 0; k < 3; k++) in >> axis[k];
    for (int k = 0; k < 9; k++) in >> r(k / 3, k % 3);
    for (int k = 0; k < 3; k++) in >> p[k];
    in >> mass;
    for (int k = 0; k < 3; k++) in >> com[k];
    for (int k = 0; k < 9; k++) in >> inertia(k / 3, k % 3);
    pin::JointModel joint;
    // the aligned joints are Pinocchio's fastest
    auto is = [&](int k) { return axis[k] == 1.0; };
    if (type == "free") joint = pin::JointModelFreeFlyer();
    else if (type == "ball") joint = pin::JointModelSpherical();
    else if (type == "hinge" && is(0)) joint = pin::JointModelRX();
    else if (type == "hinge" && is(1)) joint = pin::JointModelRY();
    else if (type == "hinge" && is(2)) joint = pin::JointModelRZ();
    else if (type == "hinge") joint = pin::JointModelRevoluteUnaligned(axis);
    else if (type == "slide") joint = pin::JointModelPrismaticUnaligned(axis);
    else { fprintf(stderr, "unknown joint %s\n", type.c_str()); return 2; }
    auto at = model.addJoint(parent < 0 ? 0 : index[parent], joint, pin::SE3(r, p), "joint" + std::to_string(i));
    model.appendBodyToJoint(at, pin::Inertia(mass, com, inertia), pin::SE3::Identity());
    index.push_back(at);
    joints.push_back({type, q, v});
    q += type == "free" ? 7 : type == "ball" ? 4 : 1;
    v += type == "free" ? 6 : type == "ball" ? 3 : 1;
  }
  if (!in || model.nq != nq || model.nv != nv) { fprintf(stderr, "bad model\n"); return 2; }

  const int width = nq + 3 * nv + nv * nv;
  MatrixXd batch(width, states);
  FILE* f = fopen(argv[2], "rb");
  if (!f || fread(batch.data(), 8, (size_t)width * states, f) != (size_t)width * states) return 2;
  fclose(f);

  std::vector<VectorXd> q(states), v(states), a(states);
  pin::Data data(model);
  double worst_tau = 0, worst_m = 0;
  for (int s = 0; s < states; s++) {
    q[s] = batch.col(s).head(nq);
    v[s] = batch.col(s).segment(nq, nv);
    a[s] = batch.col(s).segment(nq + nv, nv);
    VectorXd tau = batch.col(s).segment(nq + 2 * nv, nv);
    MatrixXd turn = MatrixXd::Identity(nv, nv);
    for (auto& j : joints) {
      if (j.type != "free" && j.type != "ball") continue;
      int quat = j.q + (j.type == "free" ? 3 : 0), omega = j.v + (j.type == "free" ? 3 : 0);
      Eigen::Vector4d wxyz = q[s].segment<4>(quat);
      q[s].segment<4>(quat) << wxyz[1], wxyz[2], wxyz[3], wxyz[0];
      Matrix3d rt = Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]).toRotationMatrix().transpose();
      for (int at = j.v; at <= omega; at += 3) turn.block<3, 3>(at, at) = rt;
    }
    v[s] = turn * v[s];
    a[s] = turn * a[s];
    for (auto& j : joints)
      if (j.type == "free") a[s].segment<3>(j.v) -= v[s].segment<3>(j.v + 3).cross(v[s].segment<3>(j.v));
    pin::rnea(model, data, q[s], v[s], a[s]);
    VectorXd theirs = turn.transpose() * data.tau;
    worst_tau = std::max(worst_tau, (theirs - tau).cwiseAbs().maxCoeff() / tau.cwiseAbs().maxCoeff());
    pin::crba(model, data, q[s]);
    MatrixXd upper = data.M.triangularView<Eigen::Upper>();
    MatrixXd full = upper + upper.transpose();
    full.diagonal() *= 0.5;
    MatrixXd m = turn.transpose() * full * turn;
    Eigen::Map<MatrixXd> ours(batch.col(s).data() + nq + 3 * nv, nv, nv);
    worst_m = std::max(worst_m, (m - ours).cwiseAbs().maxCoeff() / ours.cwiseAbs().maxCoeff());
  }

  double check = 0;
  auto least = [&](auto call) {
    double best = 1e9;
    for (int r = 0; r < 30; r++) {
      double t = now();
      for (int s = 0; s < states; s++) call(s);
      best = std::min(best, (now() - t) / states);
    }
    return 1e6 * best;
  };
  double rnea = least([&](int s) { check += pin::rnea(model, data, q[s], v[s], a[s])[0]; });
  double local = least([&](int s) { check += pin::crba(model, data, q[s], pin::Convention::LOCAL)(0, 0); });
  double world = least([&](int s) { check += pin::crba(model, data, q[s], pin::Convention::WORLD)(0, 0); });
  printf("{\"engine\":\"pinocchio %s\",\"rnea_us\":%.3f,\"crba_us\":%.3f,\"crba_local_us\":%.3f,\"crba_world_us\":%.3f,"
         "\"tau_error\":%.2e,\"mass_error\":%.2e,\"check\":%g}\n",
         FLAGS, rnea, std::min(local, world), local, world, worst_tau, worst_m, check);
  return worst_tau < 1e-9 && worst_m < 1e-9 ? 0 : 1;
}
