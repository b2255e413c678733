#include <catch2/catch.hpp>

#include "closed_forms.h"
#include "relative/bodies/exponential_map.h"
#include "relative/dynamics/equations.h"
#include "relative/start/assembly.h"

namespace concord::verification {
namespace {

using relative::Coordinates;
using relative::Kinematics;
using relative::Link;
using relative::Span;
using relative::Topology;

/// Coordinates of the opened tree moved by n_tree_u numbers in the directions of its speeds.
VecX advanced(const relative::Equations& equations, VecX q, const VecX& step) {
  const Topology& topology = equations.topology();
  for (const Link& link : topology.links) {
    const Span& joint = topology.joints[link.joint];
    equations.kinematics().mobilizer(link.joint).advance(q.data() + joint.first_q, step.data() + joint.first_u);
    const Span& modes = topology.modes[link.body];
    q.segment(modes.first_q, modes.n_q) += step.segment(modes.first_u, modes.n_u);
  }
  return q;
}

/// Change of all poses between two configurations, in the order of Y.
VecX change_of_poses(const Model& model, const Kinematics& behind, const Kinematics& ahead, const VecX& change_of_q) {
  VecX change(ahead.n_rows());
  for (relative::BodyIndex i(1); i < static_cast<int>(model.bodies.size()); ++i) {
    const int row = ahead.first_row(i);
    const Span& modes = ahead.topology().modes[i];
    change.segment<3>(row) = ahead.body(i).r - behind.body(i).r;
    change.segment<3>(row + 3) = relative::rotation_vector(ahead.body(i).A * behind.body(i).A.transpose());
    change.segment(row + 6, modes.n_u) = change_of_q.segment(modes.first_q, modes.n_q);
  }
  return change;
}

}  // namespace

TEST_CASE("Every column of the explicit B is the motion of all bodies by one speed, against differences", "[quick]") {
  for (const std::string cut : {"A", "B", "C", "D"}) {
    Model model = read("slider_crank_spatial_flexible");
    for (Joint& joint : model.joints) joint.named_as_cut = joint.name == cut;
    // Bent, so that the modes turn the joint frames that the tree passes.
    model.bodies[2].a_start = 1e-4 * VecX::LinSpaced(model.bodies[2].n_modes(), -1.0, 1.5);
    relative::Equations equations(model);
    const Coordinates start = relative::Assembly(equations).start();
    const relative::Motion& motion = equations.move(0.0, start.q, start.u);
    const MatX B = equations.kinematics().explicit_B();
    Kinematics ahead(model);
    Kinematics behind(model);
    double worst = 0.0;
    for (Eigen::Index column = 0; column < B.cols(); ++column) {
      const double h = 3e-5 / std::max(1.0, B.col(column).norm());
      const VecX step = h * VecX::Unit(equations.topology().n_tree_u, column);
      const VecX q_ahead = advanced(equations, motion.q(), step);
      const VecX q_behind = advanced(equations, motion.q(), -step);
      ahead.update(q_ahead, start.u);
      behind.update(q_behind, start.u);
      const VecX expected = change_of_poses(model, behind, ahead, q_ahead - q_behind) / (2.0 * h);
      worst = std::max(worst, (B.col(column) - expected).norm() / expected.norm());
      INFO("cut at " << cut << ", column " << column);
      CHECK((B.col(column) - expected).norm() < 1e-8 * expected.norm());
    }
    fmt::print("explicit B, cut at {}: {} x {}, worst column {:.1e} off\n", cut, B.rows(), B.cols(), worst);
  }
}

}  // namespace concord::verification
