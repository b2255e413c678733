#include "relative/loops.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace concord::relative {

namespace {

/// Pivots of Lambda relative to their diagonal entries are squares of the sine between a row and those before it: below
/// this the row is dependent.
constexpr double kDependent = 1e-13;
/// Diagonal entries below this part of the largest are squares of round-off: the row vanishes.
constexpr double kVanishing = 1e-22;

/// A second round takes off what the first left of the residual, if that is more than this part of it.
constexpr int kMostRounds = 2;
constexpr double kLeftByRoundOff = 1e-13;

}  // namespace

Loops::Loops(const Kinematics& kinematics, const Closure& closure, Elimination& elimination)
    : kinematics_(&kinematics), closure_(&closure), elimination_(&elimination) {
  lay_out_ways();
  lay_out_shared();
  const int n = closure.n_rows();
  Lambda_.setZero(n, n);
  residual_.setZero(n);
  lambda_.setZero(n);
  step_lambda_.setZero(n);
  int most_unknowns = 0;
  for (const Way& way : ways_) {
    for (const Step& step : way.steps) most_unknowns = std::max(most_unknowns, elimination.n_unknowns(step.link));
  }
  force_.setZero(most_unknowns);
  std::vector<int> all(n);
  std::iota(all.begin(), all.end(), 0);
  keep_rows(all);
}

void Loops::lay_out_ways() {
  for (std::size_t c = 0; c < closure_->cuts().size(); ++c) {
    const Closure::Cut& cut = closure_->cuts()[c];
    if (cut.measure.n_rows() == 0) continue;  // permits all six, and pulls with nothing
    lay_out({static_cast<int>(c), -1, cut.first_row, cut.measure.n_rows(), {{cut.joint, -1, -1, -1, -1}}, {}});
  }
  for (std::size_t r = 0; r < closure_->relations().size(); ++r) {
    const Relation& relation = closure_->relations()[r];
    Way way{-1, static_cast<int>(r), relation.first_row, relation.n_rows, {}, {}};
    for (std::size_t p = 0; p < relation.joints.size(); ++p) {
      way.pulls.push_back({relation.joints[p].joint, static_cast<int>(p), -1, -1, -1});
    }
    lay_out(std::move(way));
  }
}

/// Pairs of steps of two ways that stand on the same link; ways in the order of their rows.
void Loops::lay_out_shared() {
  for (int a = 0; a < static_cast<int>(ways_.size()); ++a) {
    for (int b = a; b < static_cast<int>(ways_.size()); ++b) {
      for (int i = 0; i < static_cast<int>(ways_[a].steps.size()); ++i) {
        for (int j = 0; j < static_cast<int>(ways_[b].steps.size()); ++j) {
          if (ways_[a].steps[i].link == ways_[b].steps[j].link) shared_.push_back({a, i, b, j});
        }
      }
    }
  }
}

void Loops::keep_rows(const std::vector<int>& rows) {
  kept_ = rows;
  used_ = rows;
  const auto n = static_cast<Eigen::Index>(rows.size());
  selected_.setIdentity(n, n);
  llt_.compute(selected_);
  solution_.setZero(n);
}

/// The links between the bodies of a way's joints and ground, outermost first.
void Loops::lay_out(Way way) {
  const Topology& topology = kinematics_->topology();
  const Model& model = kinematics_->model();
  std::vector<int> links;
  for (const Pull& pull : way.pulls) {
    for (const Attachment& side : model.joints[pull.joint].sides) {
      for (int l = topology.link_of_body[side.body]; l >= 0; l = topology.link_of_body[topology.links[l].reference]) {
        links.push_back(l);
      }
    }
  }
  std::sort(links.begin(), links.end(), std::greater<>());
  links.erase(std::unique(links.begin(), links.end()), links.end());
  const auto step_of = [&](int link) {
    const auto found = std::find(links.begin(), links.end(), link);
    return found == links.end() ? -1 : static_cast<int>(found - links.begin());
  };
  for (const int l : links) {
    const int m = topology.modes[topology.links[l].body].n_u;
    way.steps.push_back({l, step_of(topology.link_of_body[topology.links[l].reference]), Mat6X::Zero(6, way.n_rows),
                         MatX::Zero(m, way.n_rows), MatX::Zero(elimination_->n_unknowns(l), way.n_rows)});
  }
  for (Pull& pull : way.pulls) {
    const Joint& joint = model.joints[pull.joint];
    pull.child_step = step_of(topology.link_of_body[joint.on(Side::child).body]);
    pull.parent_step = step_of(topology.link_of_body[joint.on(Side::parent).body]);
    if (pull.part < 0) continue;
    const RelatedJoint& part = closure_->relations()[way.relation].joints[pull.part];
    if (part.cut < 0) pull.own_step = step_of(part.link);
  }
  ways_.push_back(std::move(way));
}

/// Unit multipliers pull with +T on the child of a cut joint, or with coordinate forces +C on a joint of the tree.
void Loops::load(Way& way, const Pull& pull) {
  if (pull.own_step >= 0) {
    Step& step = way.steps[pull.own_step];
    elimination_->add_coordinate_forces(step.link, closure_->relations()[way.relation].joints[pull.part].C, step.eps);
    return;
  }
  for (const Side side : {Side::child, Side::parent}) {
    if (pull.part < 0) {
      load_wrenches(way, pull, side, closure_->cuts()[way.cut].T_global.leftCols(way.n_rows));
    } else {
      load_wrenches(way, pull, side, closure_->relations()[way.relation].joints[pull.part].T_global);
    }
  }
}

/// Adds W^T T of one side to the generalized forces on its body.
void Loops::load_wrenches(Way& way, const Pull& pull, Side side, const Eigen::Ref<const Mat6X>& on_child) {
  const int at = side == Side::child ? pull.child_step : pull.parent_step;
  if (at < 0) return;
  Step& step = way.steps[at];
  const JointPoint& point = kinematics_->point(pull.joint, side);
  const Vec3 d = kinematics_->point(pull.joint, Side::child).r - kinematics_->point(pull.joint, Side::parent).r;
  for (Eigen::Index c = 0; c < step.z_r.cols(); ++c) {
    Vec6 w = on_child.col(c);
    if (side == Side::parent) w = -shift_wrench(w, d);
    step.z_r.col(c) += shift_wrench(w, point.lever);
    step.z_a.col(c).noalias() += point.Ga().transpose().lazyProduct(w);
  }
}

/// Carries the unit multipliers of one way inward to ground.
void Loops::pull(Way& way) {
  for (Step& step : way.steps) {
    step.z_r.setZero();
    step.z_a.setZero();
    step.eps.setZero();
  }
  for (const Pull& pull : way.pulls) load(way, pull);
  for (Step& step : way.steps) {
    elimination_->project(step.link, step.z_r, step.z_a, step.eps);
    if (step.next < 0) continue;
    const LinkBlocks& blocks = kinematics_->blocks(step.link);
    Step& next = way.steps[step.next];
    for (Eigen::Index c = 0; c < step.z_r.cols(); ++c) next.z_r.col(c) += shift_wrench(step.z_r.col(c), blocks.rho);
    next.z_a.noalias() += blocks.Xa.transpose().lazyProduct(step.z_r);
  }
}

/// Lambda = sum over links of eps^T eps.
void Loops::sum_Lambda() {
  Lambda_.setZero();
  for (const Shared& shared : shared_) {
    const MatX& a = ways_[shared.way].steps[shared.step].eps;
    const MatX& b = ways_[shared.other_way].steps[shared.other_step].eps;
    const int row = ways_[shared.way].first_row;
    const int column = ways_[shared.other_way].first_row;
    Lambda_.block(row, column, a.cols(), b.cols()).noalias() += a.transpose().lazyProduct(b);
  }
  Lambda_.triangularView<Eigen::StrictlyLower>() = Lambda_.transpose();
}

bool Loops::factorize(const std::vector<int>& rows) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t j = 0; j < rows.size(); ++j) selected_(i, j) = Lambda_(rows[i], rows[j]);
  }
  if (llt_.compute(selected_).info() != Eigen::Success) return false;
  for (Eigen::Index i = 0; i < selected_.rows(); ++i) {
    const double pivot = llt_.matrixLLT()(i, i);
    if (!(pivot * pivot > kDependent * selected_(i, i))) return false;
    if (!(selected_(i, i) > kVanishing * Lambda_.diagonal().maxCoeff())) return false;
  }
  return true;
}

void Loops::throw_singular(std::size_t rank) const {
  throw SolverError(fmt::format(
      "relative: the {} closure rows of the cut joints{} have rank {} in this pose, {} in a "
      "general one: the pose is singular and the motion may branch",
      closure_->n_rows(), closure_->relations().empty() ? "" : ", couplings and rolling contacts", rank, kept_.size()));
}

/// As many rows as are kept, by pivoted elimination in Lambda scaled to unit diagonal.
void Loops::choose_rows_of_this_pose() {
  const double vanishing = kVanishing * Lambda_.diagonal().maxCoeff();
  const VecX scale =
      (Lambda_.diagonal().array() > vanishing).select(Lambda_.diagonal().array().max(1e-300).sqrt().inverse(), 0.0);
  MatX rest = scale.asDiagonal() * Lambda_ * scale.asDiagonal();
  used_.clear();
  while (used_.size() < kept_.size()) {
    Eigen::Index pivot = 0;
    const double largest = rest.diagonal().maxCoeff(&pivot);
    if (!(largest > kDependent)) throw_singular(used_.size());
    used_.push_back(static_cast<int>(pivot));
    const VecX column = rest.col(pivot) / largest;
    rest -= largest * column * column.transpose();
  }
  std::sort(used_.begin(), used_.end());
}

/// Adds -Phi_u^T lambda to the right side of the tree.
void Loops::push_back(const VecX& lambda) {
  for (const Way& way : ways_) {
    const auto of_way = lambda.segment(way.first_row, way.n_rows);
    for (const Step& step : way.steps) {
      auto force = force_.head(step.eps.rows());
      force.noalias() = -step.eps.lazyProduct(of_way);
      elimination_->add_force(step.link, force);
    }
  }
}

void Loops::close(VecX& udot) {
  if (closure_->n_rows() == 0) return;
  for (Way& way : ways_) pull(way);
  sum_Lambda();
  used_ = kept_;
  lambda_.setZero();
  if (used_.empty()) return;
  if (!factorize(used_)) {
    choose_rows_of_this_pose();
    if (!factorize(used_)) throw_singular(used_.size() - 1);
  }
  const auto acceleration = [this](int joint, Side side) { return elimination_->acceleration_of_point(joint, side); };
  double first_residual = 0.0;
  for (int round = 0; round < kMostRounds; ++round) {
    closure_->compute_acceleration_residual(acceleration, udot, residual_);
    for (std::size_t i = 0; i < used_.size(); ++i) solution_(i) = residual_(used_[i]);
    // Each row by what a unit multiplier moves in it, so that units do not weigh.
    const double residual = std::sqrt((solution_.array().square() / selected_.diagonal().array()).maxCoeff());
    if (round == 0) first_residual = residual;
    if (residual <= kLeftByRoundOff * first_residual && round > 0) break;
    llt_.solveInPlace(solution_);
    step_lambda_.setZero();
    for (std::size_t i = 0; i < used_.size(); ++i) step_lambda_(used_[i]) = solution_(i);
    lambda_ += step_lambda_;
    push_back(step_lambda_);
    elimination_->outward(udot);
  }
}

}  // namespace concord::relative
