#include "compare/attribution/terms.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "common/decompositions.h"
#include "compare/audit/joint_kinematics.h"
#include "compare/audit/places.h"

namespace concord::compare {

const char* name_of(Term term) {
  switch (term) {
    case Term::inertia:
      return "inertia";
    case Term::gyroscopic:
      return "gyroscopic and Coriolis";
    case Term::modal_coupling:
      return "modal coupling";
    case Term::elastic:
      return "elastic";
    case Term::damping:
      return "damping";
    case Term::applied:
      return "applied";
    case Term::reaction:
      return "reaction";
    case Term::jacobian:
      return "Jacobian";
    case Term::bias:
      return "bias";
    case Term::driver:
      return "driver";
    case Term::rank:
      return "rank";
    case Term::side:
      return "side";
    case Term::point:
      return "point";
    case Term::frame:
      return "frame";
    case Term::subtraction:
      return "subtraction";
    case Term::start:
      return "start";
    case Term::statement:
      return "statement";
    default:
      return "unknown";
  }
}

namespace {

/// A family whose terms leave less than this over explains a fault; one that leaves more than kNothing explains
/// nothing.
constexpr double kExplained = 1e-6;
constexpr double kNothing = 0.3;

/// All that the terms of one body are made of, in one state and in the body's axes.
struct Ingredients {
  Vec3 vdot, omegadot, omega, g;
  VecX a, adot, addot;
};

Ingredients ingredients_of(const Model& model, int body, const State& state, const Evaluation& evaluation) {
  const BodyState& motion = state.bodies[body];
  const BodyAcceleration& rates = evaluation.bodies[body];
  const Mat3 to_body = rotation_of(motion.p).transpose();
  return {to_body * rates.vdot,
          to_body * rates.omegadot,
          to_body * motion.omega,
          to_body * model.gravity,
          motion.a,
          motion.adot,
          rates.addot};
}

/// Numbers put together one after the other.
class Terms {
 public:
  Terms& operator<<(const Eigen::Ref<const VecX>& more) {
    values_.insert(values_.end(), more.data(), more.data() + more.size());
    return *this;
  }
  [[nodiscard]] VecX vector() const {
    return Eigen::Map<const VecX>(values_.data(), static_cast<Eigen::Index>(values_.size()));
  }

 private:
  std::vector<double> values_;
};

/// All products of an entry of x with one of y.
VecX products(const VecX& x, const VecX& y) {
  const MatX outer = x * y.transpose();
  return outer.reshaped();
}

/// The six products of two components.
VecX squares(const Vec3& w) {
  return (VecX(6) << w(0) * w(0), w(1) * w(1), w(2) * w(2), w(0) * w(1), w(0) * w(2), w(1) * w(2)).finished();
}

/// Terms of a family in the rigid rows and in the modal ones.
struct FamilyTerms {
  VecX rigid;
  VecX modal;
};
FamilyTerms alike(const VecX& terms) { return {terms, terms}; }

struct Family {
  Term term;
  std::string whose;
  std::function<FamilyTerms(const EvaluatedState&)> terms;
};

/// A wrench in a body's axes.
VecX wrench_in(const Mat3& to_body, const Wrench& wrench) {
  return (VecX(6) << to_body * wrench.force, to_body * wrench.torque).finished();
}

/// The families of a body's own terms; each is tried before those that hold more.
std::vector<Family> own_families(const Model& model, int body, int solver) {
  using Maker = std::function<FamilyTerms(const Ingredients&)>;
  std::vector<Family> families;
  const auto add = [&](Term term, Maker make) {
    families.push_back({term, "", [&model, body, solver, make = std::move(make)](const EvaluatedState& one) {
                          return make(ingredients_of(model, body, *one.state, *one.by[solver]));
                        }});
  };
  const bool bends = model.bodies[body].n_modes() > 0;
  if (bends) {
    add(Term::damping, [](const Ingredients& x) { return alike(x.adot); });
    add(Term::elastic, [](const Ingredients& x) { return alike(x.a); });
  }
  add(Term::applied, [](const Ingredients& x) { return alike((Terms() << x.g << products(x.a, x.g)).vector()); });
  add(Term::gyroscopic,
      [](const Ingredients& x) { return alike((Terms() << squares(x.omega) << products(x.omega, x.adot)).vector()); });
  if (bends) {
    const auto coupled = [](const Ingredients& x) {
      const VecX rigid = (Terms() << x.vdot << x.omegadot).vector();
      return FamilyTerms{x.addot, rigid};
    };
    add(Term::modal_coupling, coupled);
    add(Term::modal_coupling, [](const Ingredients& x) {
      const VecX rigid = (Terms() << x.vdot << x.omegadot).vector();
      return FamilyTerms{(Terms() << x.addot << products(x.a, x.addot)).vector(),
                         (Terms() << rigid << products(x.a, rigid)).vector()};
    });
    add(Term::gyroscopic, [](const Ingredients& x) {
      const VecX turning = squares(x.omega);
      return alike((Terms() << turning << products(x.omega, x.adot) << products(turning, x.a)).vector());
    });
  }
  add(Term::inertia, [](const Ingredients& x) { return alike((Terms() << x.vdot << x.omegadot << x.addot).vector()); });
  add(Term::inertia, [](const Ingredients& x) {
    return alike((Terms() << x.vdot - x.g << x.omegadot << x.addot << squares(x.omega)).vector());
  });
  if (bends) {
    add(Term::inertia, [](const Ingredients& x) {
      const VecX rigid = (Terms() << x.vdot - x.g << x.omegadot).vector();
      return alike((Terms() << rigid << x.addot << squares(x.omega) << products(x.a, rigid)).vector());
    });
  }
  return families;
}

/// The wrenches on a body: one family for each joint side and each end of a force element.
std::vector<Family> wrench_families(const Model& model, int body, int solver) {
  std::vector<Family> families;
  const auto add = [&](Term term, const std::string& whose, auto wrench) {
    families.push_back({term, whose, [body, wrench, solver](const EvaluatedState& one) {
                          const BodyState& motion = one.state->bodies[body];
                          const VecX here = wrench_in(rotation_of(motion.p).transpose(), wrench(*one.by[solver]));
                          return alike((Terms() << here << products(here, motion.a)).vector());
                        }});
  };
  for (std::size_t k = 0; k < model.elements.size(); ++k) {
    for (const Side side : kSides) {
      const Attachment* end = end_of(model.elements[k], side);
      if (end == nullptr || end->body != body) continue;
      add(Term::applied, "force element " + model.elements[k].name,
          [k, side](const Evaluation& evaluation) { return evaluation.elements[k].on_side(side).in_global; });
    }
  }
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    for (const Side side : kSides) {
      if (model.joints[k].on(side).body != body) continue;
      add(Term::reaction, "joint " + model.joints[k].name,
          [k, side](const Evaluation& evaluation) { return evaluation.joints[k].total_on(side).in_global; });
    }
  }
  return families;
}

/// All that is applied to a body at once: force elements, and what drivers and springs exert in its joints.
Family all_applied(const Model& model, int body, int solver) {
  return {Term::applied, "", [&model, body, solver](const EvaluatedState& one) {
            const Evaluation& evaluation = *one.by[solver];
            const BodyState& motion = one.state->bodies[body];
            const Mat3 to_body = rotation_of(motion.p).transpose();
            Terms terms;
            const auto add = [&](const Wrench& wrench) {
              const VecX here = wrench_in(to_body, wrench);
              terms << here << products(here, motion.a);
            };
            for (std::size_t k = 0; k < model.elements.size(); ++k) {
              for (const Side side : kSides) {
                const Attachment* end = end_of(model.elements[k], side);
                if (end != nullptr && end->body == body) add(evaluation.elements[k].on_side(side).in_global);
              }
            }
            for (std::size_t k = 0; k < model.joints.size(); ++k) {
              for (const Side side : kSides) {
                if (model.joints[k].on(side).body != body) continue;
                const Wrench& total = evaluation.joints[k].total_on(side).in_global;
                const Wrench& reaction = evaluation.joints[k].reaction_on(side).in_global;
                add({total.force - reaction.force, total.torque - reaction.torque});
              }
            }
            return alike(terms.vector());
          }};
}

/// Columns of unit length; those of zeros stay.
MatX normalized(MatX terms) {
  for (Eigen::Index c = 0; c < terms.cols(); ++c) {
    const double size = terms.col(c).norm();
    if (size > 0.0) terms.col(c) /= size;
  }
  return terms;
}

/// Squares of what `terms` (states x terms) leave of `rows` (states x rows).
double squares_left(const MatX& terms, const MatX& rows) {
  if (terms.cols() == 0 || rows.cols() == 0) return rows.squaredNorm();
  constexpr double kDependent = 1e-10;
  return (rows - terms * smallest_least_squares(terms, rows, kDependent)).squaredNorm();
}

/// The part of `rows` that a family leaves over; 1 where it has too many terms to be held against so few states.
double part_left(const Family& family, const std::vector<EvaluatedState>& states, const MatX& rows) {
  const FamilyTerms first = family.terms(states.front());
  if (3 * std::max(first.rigid.size(), first.modal.size()) > 2 * rows.rows()) return 1.0;
  MatX rigid(rows.rows(), first.rigid.size());
  MatX modal(rows.rows(), first.modal.size());
  for (std::size_t k = 0; k < states.size(); ++k) {
    const FamilyTerms terms = family.terms(states[k]);
    rigid.row(static_cast<Eigen::Index>(k)) = terms.rigid.transpose();
    modal.row(static_cast<Eigen::Index>(k)) = terms.modal.transpose();
  }
  const double left = squares_left(normalized(rigid), rows.leftCols(6)) +
                      squares_left(normalized(modal), rows.rightCols(rows.cols() - 6));
  return std::sqrt(left / rows.squaredNorm());
}

/// What the body leaves over in every state (states x rows), each kind of row in parts of its scale.
MatX left_over(const Auditor& auditor, int body, const std::vector<EvaluatedState>& states, int solver) {
  MatX rows;
  VecX scales;
  for (std::size_t k = 0; k < states.size(); ++k) {
    const OutOfBalance one = auditor.out_of_balance(body, *states[k].state, *states[k].by[solver]);
    if (k == 0) {
      rows.resize(static_cast<Eigen::Index>(states.size()), one.rows.size());
      scales = one.scales;
    }
    rows.row(static_cast<Eigen::Index>(k)) = one.rows.transpose();
    scales = scales.cwiseMax(one.scales);
  }
  for (Eigen::Index r = 0; r < rows.cols(); ++r) {
    if (scales(r) > 0.0) rows.col(r) /= scales(r);
  }
  return rows;
}

}  // namespace

TermFit fit_term(const Model& model, const Auditor& auditor, int body, const std::vector<EvaluatedState>& states,
                 int solver) {
  TermFit best;
  if (states.empty()) return best;
  const MatX rows = left_over(auditor, body, states, solver);
  if (!rows.allFinite() || rows.norm() == 0.0) return best;
  std::vector<Family> families = own_families(model, body, solver);
  for (Family& family : wrench_families(model, body, solver)) families.push_back(std::move(family));
  families.push_back(all_applied(model, body, solver));
  std::vector<double> left;
  for (const Family& family : families) left.push_back(part_left(family, states, rows));
  const double least = *std::min_element(left.begin(), left.end());
  if (least > kNothing) return best;
  // The first, and so the smallest, family that is about as good as the best one.
  for (std::size_t k = 0; k < families.size(); ++k) {
    if (left[k] > std::max(kExplained, 2.0 * least)) continue;
    return {families[k].term, families[k].whose, left[k]};
  }
  return best;
}

namespace {

/// All products of two entries of x, each once.
VecX pairs(const VecX& x) {
  VecX all(x.size() * (x.size() + 1) / 2);
  Eigen::Index next = 0;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    for (Eigen::Index j = i; j < x.size(); ++j) all(next++) = x(i) * x(j);
  }
  return all;
}

/// How the two bodies of a joint move, in the axes of its parent's frame: rates of velocities, or velocities.
VecX seen_from(const Mat3& axes, const Vec3& linear, const Vec3& angular) {
  return (VecX(6) << axes.transpose() * linear, axes.transpose() * angular).finished();
}

}  // namespace

Term fit_joint_misfit(const Model& model, int joint, const std::vector<EvaluatedState>& states, int solver) {
  const Joint& stated = model.joints[joint];
  const std::array<int, 2> bodies{stated.on(Side::parent).body, stated.on(Side::child).body};
  const auto n = static_cast<Eigen::Index>(states.size());
  // No state that one solver closes is accepted by the other one: what is wrong is in the velocities already.
  if (n == 0) return Term::jacobian;
  const VecX unknown = VecX::Constant(stated.type->n_u(), std::numeric_limits<double>::quiet_NaN());
  MatX misfits(n, 6);
  MatX rates(n, 12);
  MatX speeds(n, 45);
  for (Eigen::Index k = 0; k < n; ++k) {
    const EvaluatedState& one = states[static_cast<std::size_t>(k)];
    const State& state = *one.state;
    const auto j = static_cast<std::size_t>(joint);
    const VecX hint = j < state.q.size() ? state.q[j] : VecX();
    const JointKinematics found = read_kinematics(stated, state, *one.by[solver], hint, unknown, model.length_scale());
    misfits.row(k) = found.acceleration.transpose();
    const Mat3 axes = place(stated.on(Side::parent), state.bodies[bodies[0]]).A_joint;
    for (int side = 0; side < 2; ++side) {
      const BodyAcceleration& rate = one.by[solver]->bodies[bodies[side]];
      rates.block(k, 6 * side, 1, 6) = seen_from(axes, rate.vdot, rate.omegadot).transpose();
    }
    const VecX moving = (VecX(9) << found.relative.v_rel, axes.transpose() * state.bodies[bodies[0]].omega).finished();
    speeds.row(k) = pairs(moving).transpose();
  }
  if (!misfits.allFinite() || !rates.allFinite()) return Term::unknown;
  // A wrong Jacobian brings a wrong bias with it: what counts is what accelerations explain beyond the speeds.
  constexpr double kExplainMuch = 0.1;
  MatX all(n, rates.cols() + speeds.cols());
  all << rates, speeds;
  const double by_speeds = squares_left(normalized(speeds), misfits);
  return squares_left(normalized(all), misfits) < kExplainMuch * by_speeds ? Term::jacobian : Term::bias;
}

}  // namespace concord::compare
