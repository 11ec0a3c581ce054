// SPDX-License-Identifier: GPL-3.0-or-later
// The bound of docs/clients-that-give.md: hand, coupling, model and client as one linear loop that
// is lifted over a period of the client. Nothing of sim is in it.
#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <unsupported/Eigen/MatrixFunctions>
#include <vector>

namespace {

using Eigen::Matrix2d;
using Eigen::Matrix4d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kTick = 1e-3, kHandMass = 0.65, kHandSpring = 300, kHandDamping = 2;

/// The exact step of M ẍ + D ẋ + K x = f + slope t.
struct ExactStep {
  Matrix2d A;
  Vector2d f, slope;
};
ExactStep exact(double M, double K, double D, double h) {
  Matrix4d G = Matrix4d::Zero();
  G(0, 1) = 1;
  G(1, 0) = -K / M;
  G(1, 1) = -D / M;
  G(1, 2) = 1 / M;
  G(2, 3) = 1;
  const Matrix4d E = (G * h).exp();
  return {E.topLeftCorner<2, 2>(), E.block<2, 1>(0, 2), E.block<2, 1>(0, 3)};
}

struct LiftedLoop {
  double coupling;  // k, held on both sides [N/m]; its damping is in proportion, 2 N·s/m at 3000
  double mass, stiffness;
  int ticks;       // of a period of the client
  double gain;     // share of the gap that a frame takes over
  bool is_spread;  // over the period, else at once
};

/// A period of the loop, from hand, model, what is left of a correction, client (place and speed)
/// and the forces of the last two periods.
VectorXd after_a_period(const LiftedLoop& loop, const VectorXd& s) {
  const int N = loop.ticks;
  const double c = 2 * loop.coupling / 3000, D = loop.stiffness > 0 ? 0.05 : 0, T = N * kTick;
  const ExactStep hand = exact(kHandMass, kHandSpring, kHandDamping, kTick);
  const ExactStep own = exact(loop.mass, loop.stiffness, D, kTick);
  const ExactStep frame = exact(loop.mass, loop.stiffness, D, T);
  Vector2d h = s.segment<2>(0), m = s.segment<2>(2), client = s.segment<2>(6);
  std::vector<double> F(s.data() + 8, s.data() + s.size());
  // the frame before this one arrives: it is replayed with what was pushed since
  Vector2d replayed = client;
  double J = 0, S = 0;
  for (int j = N; j < 2 * N; ++j) {
    const double force = F[static_cast<size_t>(j)];
    replayed[1] += kTick * force / loop.mass;
    replayed = own.A * replayed;
    J += kTick * force;
    S += kTick * force * (2 * N - j) * kTick;
  }
  const double slope = -12 * (S - 0.5 * J * T) / (T * T * T), f0 = J / T - 0.5 * slope * T;
  client = frame.A * client + frame.f * f0 + frame.slope * slope;
  Vector2d q = loop.gain * (replayed - m);
  if (!loop.is_spread) {
    m += q;
    q.setZero();
  }
  for (int j = 0; j < N; ++j) {
    m += q / N;
    q = own.A * q;
    const double force = loop.coupling * (h[0] - m[0]) + c * (h[1] - m[1]);
    F.push_back(force);
    m[1] += kTick * force / loop.mass;
    m = own.A * m;
    h = hand.A * h - hand.f * force;
  }
  VectorXd out(s.size());
  out << h, m, Vector2d::Zero(), client, Eigen::Map<VectorXd>(F.data() + N, 2 * N);
  return out;
}

/// Spectral radius, to the period: below 1 the loop rests.
double radius(const LiftedLoop& loop) {
  const int n = 8 + 2 * loop.ticks;
  MatrixXd P(n, n);
  for (int i = 0; i < n; ++i) P.col(i) = after_a_period(loop, VectorXd::Unit(n, i));
  return P.eigenvalues().cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("given: right statements are stable at any coupling, whatever mass and spring") {
  for (const int ticks : {10, 17, 33}) {
    for (const double stiffness : {0.0, 100.0, 500.0, 5000.0}) {
      for (const double mass : {0.02, 0.1, 1.0}) {
        for (const double coupling : {300.0, 3000.0, 5000.0}) {
          CAPTURE(ticks, stiffness, mass, coupling);
          CHECK(radius({coupling, mass, stiffness, ticks, 0.1, true}) < 1 + 1e-9);
        }
      }
    }
  }
}

TEST_CASE("given: at 10 Hz they are as stable") {
  CHECK(radius({5000, 0.02, 500, 100, 0.1, true}) < 1 + 1e-9);
  CHECK(radius({5000, 0.5, 5000, 100, 0.1, true}) < 1 + 1e-9);
}

TEST_CASE("given: to take over all of the gap at once is not stable beyond the bound") {
  // 20 g on 500 N/m at 30 Hz: 2 (M/T² + √(KM)/T) is 230 N/m
  CHECK(radius({200, 0.02, 500, 33, 1, false}) < 1);
  CHECK(radius({3000, 0.02, 500, 33, 1, false}) > 1.01);
}
