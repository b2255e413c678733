#include "compare/fuzz/shrink.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "compare/random_machines/placing.h"

namespace concord::compare::fuzz {

namespace {

double with_digits(double value, int digits) {
  return value == 0.0 ? 0.0 : std::stod(fmt::format("{:.{}g}", value, digits));
}

template <class Vector>
void round_all(Vector& values, int digits) {
  for (double& value : values) value = with_digits(value, digits);
}

/// Bodies that the tree still carries when the joints of `lost` are gone.
std::vector<bool> carried(const Machine& machine, const std::set<int>& lost_bodies) {
  std::vector<bool> kept(machine.bodies.size(), true);
  for (int i = 1; i < static_cast<int>(machine.bodies.size()); ++i) {
    const JointPlan& joint = machine.joints[i - 1];
    const int inner = joint.ends[joint.ends[0].body == i ? 1 : 0].body;
    kept[i] = kept[inner] && lost_bodies.count(i) == 0;
  }
  return kept;
}

/// Takes out joints by number; couplings lose the terms, and go when one term is left.
void remove_joints(Machine& machine, const std::vector<bool>& keep) {
  std::vector<int> place(keep.size(), -1);
  std::vector<JointPlan> joints;
  for (std::size_t k = 0; k < keep.size(); ++k) {
    if (!keep[k]) continue;
    place[k] = static_cast<int>(joints.size());
    joints.push_back(machine.joints[k]);
  }
  machine.joints = std::move(joints);
  std::vector<CouplingPlan> couplings;
  for (CouplingPlan& coupling : machine.couplings) {
    std::erase_if(coupling.terms, [&](const TermPlan& term) { return place[term.joint] < 0; });
    for (TermPlan& term : coupling.terms) term.joint = place[term.joint];
    if (coupling.terms.size() >= 2) couplings.push_back(coupling);
  }
  machine.couplings = std::move(couplings);
}

Machine without_body(const Machine& machine, int body) {
  Machine smaller = machine;
  const std::vector<bool> kept = carried(machine, {body});
  std::vector<int> place(kept.size(), -1);
  std::vector<BodyPlan> bodies;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (!kept[i]) continue;
    place[i] = static_cast<int>(bodies.size());
    bodies.push_back(machine.bodies[i]);
  }
  smaller.bodies = std::move(bodies);
  std::vector<bool> keep_joint;
  for (const JointPlan& joint : machine.joints) {
    keep_joint.push_back(kept[joint.ends[0].body] && kept[joint.ends[1].body]);
  }
  remove_joints(smaller, keep_joint);
  for (JointPlan& joint : smaller.joints) {
    for (End& end : joint.ends) end.body = place[end.body];
  }
  std::erase_if(smaller.elements, [&](const ElementPlan& element) {
    return !kept[element.child.body] || (element.parent && !kept[element.parent->body]);
  });
  for (ElementPlan& element : smaller.elements) {
    element.child.body = place[element.child.body];
    if (element.parent) element.parent->body = place[element.parent->body];
  }
  return smaller;
}

/// Collects the machines that a change makes, if they can be placed and are smaller.
class Candidates {
 public:
  Candidates(const Machine& machine, std::uint64_t choice)
      : machine_(machine), choice_(choice), size_(size_of(machine)) {}

  template <class Change>
  void change(const Change& what) {
    Machine candidate = machine_;
    what(candidate);
    take(std::move(candidate));
  }

  void take(Machine candidate) {
    // What was taken away may leave constraints that depend on each other, or a straight pose: the outcome decides.
    candidate.is_redundant = true;
    candidate.is_regular = false;
    if (candidate.bodies.size() < 2 || !place(candidate, choice_).ok()) return;
    if (size_of(candidate) < size_) found_.push_back(std::move(candidate));
  }

  std::vector<Machine> found() { return std::move(found_); }

 private:
  const Machine& machine_;
  std::uint64_t choice_;
  double size_;
  std::vector<Machine> found_;
};

void take_parts(const Machine& machine, Candidates& candidates) {
  for (std::size_t k = machine.bodies.size() - 1; k >= 1; --k) {
    candidates.take(without_body(machine, static_cast<int>(k)));
  }
  for (std::size_t k = machine.bodies.size() - 1; k < machine.joints.size(); ++k) {
    std::vector<bool> keep(machine.joints.size(), true);
    keep[k] = false;
    candidates.change([&](Machine& one) { remove_joints(one, keep); });
  }
  if (machine.elements.size() > 1) candidates.change([](Machine& one) { one.elements.clear(); });
  for (std::size_t k = 0; k < machine.elements.size(); ++k) {
    candidates.change([&](Machine& one) { one.elements.erase(one.elements.begin() + static_cast<long>(k)); });
  }
  for (std::size_t k = 0; k < machine.couplings.size(); ++k) {
    candidates.change([&](Machine& one) { one.couplings.erase(one.couplings.begin() + static_cast<long>(k)); });
  }
}

/// A flexible body becomes rigid; what sits on its nodes stays where it is.
void take_modes(const Machine& machine, Candidates& candidates) {
  for (std::size_t i = 1; i < machine.bodies.size(); ++i) {
    if (!machine.bodies[i].flexible) continue;
    candidates.change([&](Machine& one) { one.bodies[i].flexible.reset(); });
    candidates.change([&](Machine& one) {
      one.bodies[i].flexible->a.setZero();
      one.bodies[i].flexible->adot.setZero();
    });
  }
}

void take_entries(Entries& entries, std::size_t k) { entries.erase(entries.begin() + static_cast<long>(k)); }

void take_terms(const Machine& machine, Candidates& candidates) {
  for (std::size_t k = 0; k < machine.joints.size(); ++k) {
    for (std::size_t c = 0; c < machine.joints[k].coordinates.size(); ++c) {
      const CoordinatePlan& plan = machine.joints[k].coordinates[c];
      if (plan.law) {
        candidates.change([&](Machine& one) {
          one.joints[k].coordinates[c].drive.clear();
          one.joints[k].coordinates[c].law.reset();
        });
      }
      if (plan.spring.empty()) continue;
      candidates.change([&](Machine& one) { one.joints[k].coordinates[c].spring.clear(); });
      for (std::size_t e = 0; plan.spring.size() > 1 && e < plan.spring.size(); ++e) {
        candidates.change([&](Machine& one) { take_entries(one.joints[k].coordinates[c].spring, e); });
      }
    }
  }
  for (std::size_t k = 0; k < machine.elements.size(); ++k) {
    for (std::size_t e = 0; e < machine.elements[k].entries.size(); ++e) {
      if (machine.elements[k].entries[e].needed) continue;
      candidates.change([&](Machine& one) { take_entries(one.elements[k].entries, e); });
    }
  }
}

void straighten(const Machine& machine, Candidates& candidates) {
  candidates.change([](Machine& one) {
    for (JointPlan& joint : one.joints) joint.u.setZero();
  });
  candidates.change([](Machine& one) {
    for (JointPlan& joint : one.joints) {
      for (End& end : joint.ends) end.p = Vec4::Unit(0);
    }
  });
  for (std::size_t k = 0; k < machine.joints.size(); ++k) {
    candidates.change([&](Machine& one) { one.joints[k].u.setZero(); });
    candidates.change([&](Machine& one) {
      JointPlan& joint = one.joints[k];
      for (int w = 0; w < static_cast<int>(joint.type->permits.size()); ++w) {
        const VecX home = joints::home_of(joint.type->permits[w]);
        joint.q.segment(first_q(*joint.type, w), home.size()) = home;
      }
    });
    candidates.change([&](Machine& one) { one.joints[k].named_as_cut = false; });
    for (int side = 0; side < 2; ++side) {
      candidates.change([&](Machine& one) { one.joints[k].ends[side].p = Vec4::Unit(0); });
      candidates.change([&](Machine& one) {
        End& end = one.joints[k].ends[side];
        const auto& flexible = one.bodies[end.body].flexible;
        end.point = flexible ? flexible->nodes[end.node] : Vec3(Vec3::Zero());
      });
    }
  }
  for (std::size_t i = 1; i < machine.bodies.size(); ++i) {
    candidates.change([&](Machine& one) { one.bodies[i].center_of_mass.setZero(); });
    candidates.change([&](Machine& one) {
      const double mean = one.bodies[i].inertia.head<3>().mean();
      one.bodies[i].inertia << Vec3::Constant(mean), Vec3::Zero();
    });
  }
  candidates.change([](Machine& one) { one.gravity.setZero(); });
  candidates.change([](Machine& one) { one.gravity = Vec3(0.0, 0.0, -9.81); });
}

/// All numbers of joints, bodies and the run with fewer digits; frames stay what they are.
void round_numbers(Machine& machine, int digits) {
  machine.gravity = machine.gravity.unaryExpr([&](double value) { return with_digits(value, digits); });
  for (BodyPlan& body : machine.bodies) {
    body.mass = with_digits(body.mass, digits);
    round_all(body.center_of_mass, digits);
    round_all(body.inertia, digits);
  }
  for (JointPlan& joint : machine.joints) {
    round_all(joint.parameters, digits);
    for (End& end : joint.ends) {
      if (!machine.bodies[end.body].flexible) round_all(end.point, digits);
      round_all(end.p, digits + 1);
      end.p.normalize();
    }
    round_all(joint.q, digits);
    for (int w = 0; w < static_cast<int>(joint.type->permits.size()); ++w) {
      if (!is_orientation(joint.type->permits[w])) continue;
      joint.q.segment<4>(first_q(*joint.type, w)).normalize();
    }
    round_all(joint.u, digits);
  }
}

double digits_in(double value) { return value == 0.0 ? 0.0 : static_cast<double>(number_text(value).size()); }

template <class Vector>
double digits_in_all(const Vector& values) {
  double sum = 0.0;
  for (const double value : values) sum += digits_in(value);
  return sum;
}

double digits_of(const End& end) {
  return digits_in_all(end.point) + (end.p == Vec4::Unit(0) ? 0.0 : digits_in_all(end.p));
}

}  // namespace

double size_of(const Machine& machine) {
  constexpr double kPart = 1e6;
  constexpr double kTerm = 1e4;
  double size = digits_in_all(machine.gravity);
  for (const BodyPlan& body : machine.bodies) {
    size += kPart + digits_in(body.mass) + digits_in_all(body.center_of_mass) + digits_in_all(body.inertia);
    if (body.flexible) size += 0.5 * kPart + digits_in_all(body.flexible->a) + digits_in_all(body.flexible->adot);
  }
  for (const JointPlan& joint : machine.joints) {
    size += kPart + digits_of(joint.ends[0]) + (joint.closes_loop ? 0.0 : digits_of(joint.ends[1]));
    size += digits_in_all(joint.q) + digits_in_all(joint.u) + digits_in_all(joint.parameters) + joint.named_as_cut;
    for (const CoordinatePlan& plan : joint.coordinates) {
      size += kTerm * static_cast<double>((plan.law ? 2U : 0U) + plan.spring.size());
    }
  }
  for (const CouplingPlan& coupling : machine.couplings) size += kPart + static_cast<double>(coupling.terms.size());
  for (const ElementPlan& element : machine.elements) {
    size += kPart + kTerm * static_cast<double>(element.entries.size());
  }
  return size;
}

std::vector<Machine> smaller_machines(const Machine& machine, std::uint64_t choice) {
  Candidates candidates(machine, choice);
  take_parts(machine, candidates);
  take_modes(machine, candidates);
  take_terms(machine, candidates);
  for (const int digits : {1, 2, 4}) {
    candidates.change([&](Machine& one) { round_numbers(one, digits); });
  }
  straighten(machine, candidates);
  return candidates.found();
}

Machine shrink(Machine machine, std::uint64_t choice, const FirstThatKeeps& first_that_keeps) {
  constexpr int kMostSteps = 100;
  std::size_t from = 0;  // changes before this one did not keep the outcome a step ago: they are tried again last
  for (int step = 0; step < kMostSteps; ++step) {
    std::vector<Machine> candidates = smaller_machines(machine, choice);
    if (candidates.empty()) break;
    from %= candidates.size();
    std::rotate(candidates.begin(), candidates.begin() + static_cast<long>(from), candidates.end());
    const auto kept = first_that_keeps(candidates);
    if (!kept) break;
    machine = std::move(candidates[*kept]);
    from += *kept;
  }
  return machine;
}

}  // namespace concord::compare::fuzz
