#include "relative/forces/applied_forces.h"

#include <gtest/gtest.h>

#include "common/decompositions.h"
#include "machines.h"
#include "relative/solver.h"
#include "relative/start/assembly.h"
#include "relative/start/states.h"

namespace concord::relative {
namespace {

/// Place and frame of an end, from the state alone.
Pose end_pose(const State& state, const Attachment& at) {
  const BodyState& body = state.bodies[at.body];
  const Mat3 A = test::rotation_of(body);
  if (at.Psi_r_L.cols() == 0) return {body.r + A * at.point_L, A * at.C};
  const Vec3 theta = at.Psi_r_L * body.a;
  return {body.r + A * (at.point_L + at.Psi_t_L * body.a),
          A * rotation_about(Vec3(theta.normalized()), theta.norm()) * at.C};
}

/// The child's end as the parent's sees it: [d; rotation vector].
Vec6 seen_from_parent(const State& state, const std::array<Attachment, 2>& ends) {
  const Pose parent = end_pose(state, ends[0]);
  const Pose child = end_pose(state, ends[1]);
  const Eigen::AngleAxisd turned(parent.A.transpose() * child.A);
  Vec6 seen;
  seen << parent.A.transpose() * (child.r - parent.r), turned.angle() * turned.axis();
  return seen;
}

/// What a law resists at x, integrated from 0 with Simpson's rule, without damping: its potential.
double potential(const ForceLaw& law, double x) {
  double sum = 0.0;
  const int n = 400;
  for (int i = 0; i < n; ++i) {
    const auto force = [&](double part) { return evaluate_resistance(law, x * (i + part) / n, 0.0).force; };
    sum += (force(0.0) + 4.0 * force(0.5) + force(1.0)) * x / (6.0 * n);
  }
  return sum;
}

double potential(const LineSpring& spring, const State& state) {
  return potential(spring.law, (end_pose(state, spring.ends[1]).r - end_pose(state, spring.ends[0]).r).norm());
}

double potential(const TurnSpring& spring, const State& state) {
  const Mat3 A = end_pose(state, spring.ends[0]).A;
  const Vec3 x = end_pose(state, spring.ends[1]).A.col(0);
  return potential(spring.law, std::atan2(x.dot(A.col(1)), x.dot(A.col(0))));
}

double potential(const Bushing& bushing, const State& state) {
  const Vec6 seen = seen_from_parent(state, bushing.ends);
  return 0.5 * seen.dot(bushing.stiffness * seen) - bushing.preload.dot(seen);
}

/// A machine whose open tree moves along constant speeds u from the start.
class PushedMachine {
 public:
  explicit PushedMachine(const Model& model) : model_(model), equations_(model_) {
    start_ = Assembly(equations_).start();
    u_ = test::Numbers(19).vector(equations_.topology().n_u, 1.2);
  }

  State move(double h) {
    VecX q = start_.q;
    const Topology& topology = equations_.topology();
    for (const Link& link : topology.links) {
      const Span& joint = topology.joints[link.joint];
      const VecX step = h * u_.segment(joint.first_u, joint.n_u);
      equations_.kinematics().mobilizer(link.joint).advance(q.data() + joint.first_q, step.data());
      const Span& modes = topology.modes[link.body];
      q.segment(modes.first_q, modes.n_q) += h * u_.segment(modes.first_u, modes.n_u);
    }
    return States(equations_).write(equations_.move(0.0, q, u_), {});
  }

  /// Rate along the speeds of a function of the state, by central differences.
  template <class F>
  double rate(const F& f) {
    const double h = 1e-5;
    const double ahead = f(move(h));
    return (ahead - f(move(-h))) / (2.0 * h);
  }

  /// Power of the generalized forces on bodies and on the tree's speeds.
  double power_of_generalized_forces(double t) {
    move(0.0);
    AppliedForces applied(equations_.kinematics(), equations_.closure());
    applied.update(equations_.move(t, equations_.motion().q(), equations_.motion().u()));
    const Topology& topology = equations_.topology();
    double power = applied.tau().head(topology.n_tree_u).dot(u_.head(topology.n_tree_u));
    for (std::size_t l = 0; l < topology.links.size(); ++l) {
      const BodyIndex body = topology.links[l].body;
      const BodyMotion& motion = equations_.kinematics().body(body);
      const Vec6& Q = applied.on_body(LinkIndex(l));
      power += Q.head<3>().dot(motion.v) + Q.tail<3>().dot(motion.omega);
      const Span& modes = topology.modes[body];
      power += applied.on_modes(LinkIndex(l)).dot(u_.segment(modes.first_u, modes.n_u));
    }
    EXPECT_NEAR(power, applied.power(), 1e-12 * (1.0 + std::abs(power)));
    return power;
  }

 private:
  Model model_;
  Equations equations_;
  Coordinates start_;
  VecX u_;
};

class ElementOnTree : public ::testing::TestWithParam<std::tuple<bool, int>> {
 protected:
  /// The tree of all joints with one element; damping and actuators are left to a test of their own.
  static Model machine(bool conservative) {
    Model model = test::tree_of_all_joints(std::get<0>(GetParam()));
    test::Numbers numbers(83);
    test::add_force_elements(model, numbers);
    model.elements = {model.elements[std::get<1>(GetParam())]};
    if (!conservative) return model;
    ForceElement& element = model.elements.front();
    if (auto* line = std::get_if<LineSpring>(&element.what)) {
      line->law.damping = 0.0;
      line->law.actuator.reset();
      line->law.upper->damping = 0.0;
    }
    if (auto* turn = std::get_if<TurnSpring>(&element.what)) {
      turn->law.damping = 0.0;
      turn->law.actuator.reset();
      turn->law.upper->damping = 0.0;
    }
    if (auto* bushing = std::get_if<Bushing>(&element.what)) bushing->damping.setZero();
    return model;
  }
};

TEST_P(ElementOnTree, TakesItsPowerFromItsPotential) {
  const Model model = machine(true);
  PushedMachine pushed(model);
  const double power = pushed.power_of_generalized_forces(0.0);
  const double rate = std::visit(
      [&](const auto& element) {
        if constexpr (requires(const State& state) { potential(element, state); }) {
          return pushed.rate([&](const State& state) { return -potential(element, state); });
        } else if constexpr (std::is_same_v<std::decay_t<decltype(element)>, Tire>) {
          return 0.0;  // has none, and is not among these elements
        } else {       // the load as it is now, on the way of its point and frame
          const Pose at = end_pose(pushed.move(0.0), element.at);
          const Mat3 body_A = test::rotation_of(pushed.move(0.0).bodies[element.at.body]);
          const Mat3 axes = element.axes == LoadAxes::global ? Mat3(Mat3::Identity())
                            : element.axes == LoadAxes::body ? body_A
                                                             : at.A;
          const double size = evaluate(element.law, 0.0).f;
          return pushed.rate([&](const State& state) {
            const Pose moved = end_pose(state, element.at);
            const Eigen::AngleAxisd turned(moved.A * at.A.transpose());
            return size * (axes * element.force).dot(moved.r - at.r) +
                   size * (axes * element.torque).dot(turned.angle() * turned.axis());
          });
        }
      },
      model.elements.front().what);
  EXPECT_NEAR(power, rate, 1e-7 * (1.0 + std::abs(rate)));
  EXPECT_GT(std::abs(power), 1e-2);
}

TEST_P(ElementOnTree, DampsByItsRateAndPullsByItsActuator) {
  const double t = 0.37;
  const Model model = machine(false);
  const double of_spring = PushedMachine(machine(true)).power_of_generalized_forces(t);
  PushedMachine pushed(model);
  const double power = pushed.power_of_generalized_forces(t) - of_spring;
  const auto pulled = [&](const ForceLaw& law, double x, double xdot) {
    const double damping = evaluate_resistance(law, x, xdot).force - evaluate_resistance(law, x, 0.0).force;
    return -(damping + evaluate(*law.actuator, t).f) * xdot;
  };
  double expected = 0.0;
  if (const auto* line = std::get_if<LineSpring>(&model.elements.front().what)) {
    const auto x = [&](const State& s) { return (end_pose(s, line->ends[1]).r - end_pose(s, line->ends[0]).r).norm(); };
    expected = pulled(line->law, x(pushed.move(0.0)), pushed.rate(x));
  } else if (const auto* turn = std::get_if<TurnSpring>(&model.elements.front().what)) {
    const auto x = [&](const State& s) {
      const Vec3 c = end_pose(s, turn->ends[0]).A.transpose() * end_pose(s, turn->ends[1]).A.col(0);
      return std::atan2(c.y(), c.x());
    };
    expected = pulled(turn->law, x(pushed.move(0.0)), pushed.rate(x));
  } else if (const auto* bushing = std::get_if<Bushing>(&model.elements.front().what)) {
    Vec6 v_rel;
    for (int c = 0; c < 3; ++c) {
      v_rel(c) = pushed.rate([&](const State& s) { return seen_from_parent(s, bushing->ends)(c); });
    }
    const auto relative = [&](const State& s) -> Mat3 {
      return end_pose(s, bushing->ends[0]).A.transpose() * end_pose(s, bushing->ends[1]).A;
    };
    const Mat3 R = relative(pushed.move(0.0));
    for (int c = 0; c < 3; ++c) {
      v_rel(3 + c) = pushed.rate([&](const State& s) {
        const Mat3 turned = relative(s) * R.transpose();
        return 0.5 * (turned((c + 2) % 3, (c + 1) % 3) - turned((c + 1) % 3, (c + 2) % 3));
      });
    }
    expected = -v_rel.dot(bushing->damping * v_rel);
  }
  EXPECT_NEAR(power, expected, 1e-7 * (1.0 + std::abs(expected)));
}

INSTANTIATE_TEST_SUITE_P(Elements, ElementOnTree, ::testing::Combine(::testing::Bool(), ::testing::Range(0, 6)));

/// Everything that pushes at once, on a loop with flexible bodies: wrenches on both sides hold every body in balance.
class PushedLoop : public ::testing::TestWithParam<int> {};

TEST_P(PushedLoop, IsInBalanceWhereverItIsCut) {
  Model model = test::spatial_slider_crank(true);
  test::Numbers numbers(29);
  test::add_force_elements(model, numbers);
  for (Joint& joint : model.joints) test::add_springs(joint);
  const State state = make_solver(model)->assemble();
  const Evaluation ruled = make_solver(model)->evaluate(state);
  model.joints[GetParam()].named_as_cut = true;
  const Evaluation named = make_solver(model)->evaluate(state);
  const test::Imbalance left_over = test::imbalance(model, state, named);
  EXPECT_LT(left_over.force + left_over.torque + left_over.modal, 1e-10);
  ASSERT_EQ(named.elements.size(), model.elements.size());
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    for (const Side side : {Side::parent, Side::child}) {
      const auto reaction = [&](const Evaluation& e) { return e.joints[k].reaction_on(side).in_C.vector(); };
      const auto total = [&](const Evaluation& e) { return e.joints[k].total_on(side).in_C.vector(); };
      EXPECT_LT((reaction(ruled) - reaction(named)).norm(), 1e-10) << k;
      EXPECT_LT((total(ruled) - total(named)).norm(), 1e-10) << k;
    }
    EXPECT_LT((ruled.joints[k].tau - named.joints[k].tau).norm(), 1e-10) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(CutAtEach, PushedLoop, ::testing::Range(0, 4));

std::vector<const joints::JointType*> types_that_take_springs() {
  std::vector<const joints::JointType*> types = test::all_types();
  std::erase_if(types, [](const joints::JointType* type) {
    return std::all_of(type->permits.begin(), type->permits.end(),
                       [](const joints::Permit& word) { return std::holds_alternative<joints::Ball>(word); });
  });
  return types;
}

/// A spring on every coordinate of every type, free and with a driver on the first one.
class SprungType : public ::testing::TestWithParam<const joints::JointType*> {};

TEST_P(SprungType, PushesTheSameInTheTreeAndCut) {
  for (const bool driven : {false, true}) {
    Model model = test::pair(*GetParam(), 3);
    Joint& joint = model.joints[2];
    test::add_springs(joint);
    joint.springs.front().law.actuator = Harmonic{0.7, 0.4, 5.0, 0.1};
    const JointSpring& first = joint.springs.front();
    if (driven) {
      const std::size_t n_permitted = joint.type->permits_speeds.size();
      if (n_permitted > 0) test::keep_speeds_in_space(model, n_permitted - 1);
      WordStart& start = joint.start[first.word];
      for (int c = 0; c < start.q.size(); ++c) {
        joint.drivers.push_back({first.word, Polynomial{{start.q(c), start.u(c), 1.7 - c}}, c});
      }
      start.role_q = start.role_u = StartRole::unsaid;
    }
    Model cut = model;
    cut.joints[2].named_as_cut = true;
    model.joints[1].named_as_cut = true;
    const State state = make_solver(model)->assemble();
    const Evaluation by_tree = make_solver(model)->evaluate(state);
    const Evaluation by_cut = make_solver(cut)->evaluate(state);
    for (const Evaluation* evaluation : {&by_tree, &by_cut}) {
      const test::Imbalance left_over = test::imbalance(model, state, *evaluation);
      EXPECT_LT(left_over.force + left_over.torque + left_over.modal, 1e-10);
    }
    for (const Side side : {Side::parent, Side::child}) {
      const auto difference = [&](auto of) { return (of(by_tree) - of(by_cut)).norm(); };
      EXPECT_LT(difference([&](const Evaluation& e) { return e.joints[2].reaction_on(side).in_C.vector(); }), 1e-10);
      EXPECT_LT(difference([&](const Evaluation& e) { return e.joints[2].total_on(side).in_C.vector(); }), 1e-10);
    }
    EXPECT_LT((by_tree.joints[2].tau - by_cut.joints[2].tau).norm(), 1e-10);
    // The reaction is workless in every direction; the total works against tau.
    const Pose parent = end_pose(state, joint.on(Side::parent));
    JointMotion motion;
    Mobilizer(*joint.type).evaluate(state.q[2].data(), state.u[2].data(), motion);
    const Mobilizer permitted(*joint.type);
    NonholonomicConstraint speeds(*joint.type, permitted);
    MatX free = MatX::Identity(joint.type->n_u(), joint.type->n_u());
    if (speeds.n_rows() > 0) {
      speeds.evaluate(motion, joint.name);
      free = kernel_of(speeds.C().transpose());
    }
    const Mat6X S = motion.S.leftCols(joint.type->n_u()) * free;
    for (const Evaluation* evaluation : {&by_tree, &by_cut}) {
      const auto work = [&](const SideWrench& side) -> VecX {
        Vec6 w;
        w << parent.A.transpose() * side.in_global.force, parent.A.transpose() * side.in_global.torque;
        return S.transpose() * w;
      };
      EXPECT_LT(work(evaluation->joints[2].reaction_on(Side::child)).norm(), 1e-10);
      EXPECT_LT(
          (work(evaluation->joints[2].total_on(Side::child)) - free.transpose() * evaluation->joints[2].tau).norm(),
          1e-10);
    }
    for (const JointSpring& spring : joint.springs) {
      const int q = first_q(*joint.type, spring.word) + spring.component;
      const int u = first_u(*joint.type, spring.word) + spring.component;
      const double law =
          evaluate_actuator(spring.law, 0.0) - evaluate_resistance(spring.law, state.q[2](q), state.u[2](u)).force;
      const bool is_driven = driven && spring.word == first.word;
      if (is_driven) {
        EXPECT_GT(std::abs(by_cut.joints[2].tau(u) - law), 1e-3);
      } else {
        EXPECT_NEAR(by_cut.joints[2].tau(u), law, 1e-12);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Catalogue, SprungType, ::testing::ValuesIn(types_that_take_springs()),
                         [](const auto& tested) { return tested.param->name; });

/// What the solver says of a machine whose one element connects a hinged body with ground.
std::string refusal_of_hinge_with(const std::function<void(Model&)>& add) {
  test::Numbers numbers(3);
  Model model;
  model.file = "hinge.toml";
  model.bodies = {test::ground(), test::rigid_body("door", numbers)};
  model.joints = {test::joint(model, "hinge", "revolute", 0, 1, numbers)};
  model.joints[0].start[0].q(0) = 3.1;
  model.joints[0].start[0].u(0) = 0.0;
  add(model);
  const std::unique_ptr<Solver> solver = make_solver(model);
  try {
    (void)solver->evaluate(solver->assemble());
  } catch (const SolverError& error) {
    return error.what();
  }
  return "no complaint";
}

TEST(CountedAngle, IsTheOneNearestToWhereItsRatesLead) {
  CountedAngle angle;
  angle.known = {2.0, 100.0, 30.0};
  const auto exact = [](double t) { return 100.0 + 30.0 * (t - 2.0) - 40.0 * (t - 2.0) * (t - 2.0); };
  for (const double t : {1.5, 1.99, 2.0, 2.2, 2.9}) {  // turns apart, before and after
    const double x = exact(t);
    EXPECT_NEAR(angle.count(t, std::remainder(x, 2.0 * M_PI), 30.0 - 80.0 * (t - 2.0)), x, 1e-12) << t;
    EXPECT_NEAR(angle.stray(), 0.0, 1e-12);
  }
  (void)angle.count(2.4, std::remainder(exact(2.4) + 1.7, 2.0 * M_PI), 30.0 - 80.0 * 0.4);
  EXPECT_NEAR(angle.stray(), 1.7, 1e-12) << "beyond a quarter turn: not to be trusted";
  angle.follow();
  EXPECT_EQ(angle.known.t, 2.4);
  EXPECT_NEAR(angle.count(2.4, std::remainder(exact(2.4), 2.0 * M_PI), 0.0), exact(2.4), 1e-12) << "a single state";
}

TEST(AppliedForces, ATurnSpringCountsTurnsFromWhatTheStateSays) {
  test::Numbers numbers(71);
  Model model;
  model.file = "coil.toml";
  model.bodies = {test::ground(), test::rigid_body("door", numbers)};
  model.joints = {test::joint(model, "hinge", "revolute", 0, 1, numbers)};
  TurnSpring coil{model.joints[0].sides, {}};
  coil.law.stiffness = 7.0;
  model.elements.push_back({"coil", coil, {}});
  const std::unique_ptr<Solver> solver = make_solver(model);
  State state = solver->assemble();
  const double angle = state.q[0](0);
  for (const int turns : {-3, 0, 2}) {
    const double counted = angle + 2.0 * M_PI * turns;
    state.spring_angles = {counted + 3.1};
    const Evaluation found = solver->evaluate(state);
    EXPECT_NEAR(found.elements[0].on_side(Side::child).in_C.torque.z(), -7.0 * counted, 1e-12) << turns;
    const std::optional<State> closed = solver->close(state);
    ASSERT_TRUE(closed);
    EXPECT_NEAR(closed->spring_angles.at(0), counted, 1e-13) << turns;
  }
}

TEST(AppliedForces, RefuseElementsThatAreNotDefined) {
  // The frames of a hinge meet in one point, but for round-off.
  const std::string strut = refusal_of_hinge_with([](Model& model) {
    LineSpring spring{model.joints[0].sides, {}};
    spring.law.preload = 3.0;
    model.elements.push_back({"strut", spring, {}});
  });
  EXPECT_TRUE(strut.starts_with("relative: force element 'strut': its ends are ")) << strut;
  EXPECT_TRUE(strut.ends_with(" m apart, so that its force has no direction: move an end")) << strut;
  EXPECT_EQ(refusal_of_hinge_with([](Model& model) {
              model.elements.push_back({"coil", TurnSpring{model.joints[0].sides, {}}, {}});
            }),
            "no complaint");
  EXPECT_EQ(refusal_of_hinge_with([](Model& model) {
              model.elements.push_back({"bearing", Bushing{model.joints[0].sides}, {}});
            }),
            "no complaint");
  EXPECT_EQ(
      refusal_of_hinge_with([](Model& model) {
        model.elements.push_back({"mount", Bushing{model.joints[0].sides, Mat6::Identity()}, {}});
      }),
      "relative: force element 'mount': its ends are turned by 177.6 deg against each other, allowed are 175 deg: "
      "turn the frames of its ends");
  EXPECT_EQ(refusal_of_hinge_with([](Model& model) {
              std::array<Attachment, 2> ends = model.joints[0].sides;
              Mat3 cyclic;
              cyclic << 0, 1, 0, 0, 0, 1, 1, 0, 0;  // its x axis along the hinge
              ends[1].C *= cyclic;
              model.elements.push_back({"coil", TurnSpring{ends, {}}, {}});
            }),
            "relative: force element 'coil': the child's x axis points along the parent's z, so that it has no angle: "
            "turn the frames of its ends");
}

}  // namespace
}  // namespace concord::relative
