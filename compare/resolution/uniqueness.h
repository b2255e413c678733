#pragma once

#include <array>
#include <vector>

#include "compare/quantities/agreement.h"
#include "compare/quantities/align.h"
#include "compare/states/singular_pose.h"

/// Which quantities are unique in which states, as both solvers find it, state by state.
namespace concord::compare {

/// What one solver says of a quantity in a state.
enum class Uniqueness { unique, undecided, not_unique };

/// Whether anything can pass along a component: a joint's reaction where the joint forbids motion, its total wrench
/// also where something acts on its coordinates; true of all that is no wrench of a joint.
bool can_carry(const Model& model, const Quantity& quantity);

/// Uniqueness of every quantity of the layout by one solver's report. A reaction in global axes is unique if all three
/// components of its force, or of its torque, are; accelerations, force elements and sums on bodies always are.
std::vector<Uniqueness> uniqueness_of(const QuantityLayout& layout, const RankReport& report);

/// Which of them are unique, and not undecided.
Eigen::Array<bool, Eigen::Dynamic, 1> unique_rows(const QuantityLayout& layout, const RankReport& report);

/// Which of them are not unique, and not undecided.
Eigen::Array<bool, Eigen::Dynamic, 1> open_rows(const QuantityLayout& layout, const RankReport& report);

/// Where both find a quantity unique, and nothing is undecided.
Mask judged_states(const QuantityLayout& layout, const RankReports& reports);

/// Axes of joints may line up at a time, so that a component is unique there alone: what is open in more of the
/// `samples` than it is unique in (columns of both; rows of the layout) counts as not unique anywhere.
void leave_out_isolated(Mask& unique, const Mask& open, const std::vector<Eigen::Index>& samples);

/// The same by the states of a run among those in which both solvers were asked.
void leave_out_isolated(const QuantityLayout& layout, const std::vector<SharedState>& states,
                        const RankReports& reports, Mask& unique);

/// What the two solvers say differently of the same state: of redundant constraints, degrees of freedom, uniqueness of
/// reactions, totals, and forces of drivers and couplings. One finding for each of these and each owner, with the
/// number of states; what is undecided is no difference.
std::vector<Finding> compare_uniqueness(const QuantityLayout& layout, const std::vector<SharedState>& states,
                                        const RankReports& reports);

/// The mask in the samples of a run: a quantity is judged in a sample if it is in all states taken from it.
Mask mask_of_run(const Mask& mask, const std::vector<SharedState>& states, int samples);

}  // namespace concord::compare
