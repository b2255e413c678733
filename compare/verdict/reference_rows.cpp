#include "compare/verdict/reference_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include "common/decompositions.h"
#include "compare/audit/machine_rank.h"
#include "compare/quantities/columns.h"
#include "compare/verdict/reference_errors.h"

namespace concord::compare {

namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr double kRoundOff = 1e-14;      // of the machine's largest number
constexpr double kOfSelfStress = 1e-12;  // the same of what self-stresses explain

/// What a reference says of the owner of a column, and the runs, at those of its times at which the column has a number
/// that follows from the machine alone there; if there is none, at all at which it has one.
struct ChosenTimes {
  Reference reference;
  std::size_t column = 0;  // the column, among those of its owner
  RunsAtTimes runs;
  bool is_judged;
};

ChosenTimes choose_times(const Reference& reference, const Standard& standard, std::size_t column) {
  const RunsAtTimes& runs = standard.runs;
  const ReferenceColumn& asked = reference.columns[column];
  std::vector<std::size_t> said;
  std::vector<std::size_t> judged;
  for (std::size_t k = 0; k < runs.samples.size(); ++k) {
    if (std::isnan(asked.values[k])) continue;
    said.push_back(k);
    const bool is_unique = !std::isnan(value_of(asked.column, *standard.known[k]));
    if (is_unique && !asked.column.is_own) judged.push_back(k);
  }
  const std::vector<std::size_t>& kept = judged.empty() ? said : judged;
  const auto of_kept = [&](const auto& numbers) {
    std::decay_t<decltype(numbers)> chosen;
    for (const std::size_t k : kept) chosen.push_back(numbers[k]);
    return chosen;
  };
  ChosenTimes chosen{
      {}, 0, {runs.verdict, of_kept(runs.samples), {of_kept(runs.at[0]), of_kept(runs.at[1])}}, !judged.empty()};
  chosen.reference.times = of_kept(reference.times);
  chosen.reference.lines = of_kept(reference.lines);
  for (std::size_t k = 0; k < reference.columns.size(); ++k) {
    const ReferenceColumn& one = reference.columns[k];
    if (one.column.field != asked.column.field || one.column.owner != asked.column.owner) continue;
    if (k == column) chosen.column = chosen.reference.columns.size();
    chosen.reference.columns.push_back(one);
    chosen.reference.columns.back().values = of_kept(one.values);
  }
  return chosen;
}

/// The sign by which Euler parameters of a reference are those of a solver in sample k: one for all that it gives of an
/// orientation, so that an inverse rotation is none. 1 for all other columns.
double sign_of(const RunsAtTimes& runs, std::size_t who, std::size_t k, const Reference& reference,
               const Column& column) {
  if (!has_free_sign(column)) return 1.0;
  double product = 0.0;
  for (const ReferenceColumn& other : reference.columns) {
    const bool is_of_it =
        has_free_sign(other.column) && other.column.field == column.field && other.column.owner == column.owner;
    if (is_of_it && !std::isnan(other.values[k]))
      product += value_of(other.column, runs.sample(who, k)) * other.values[k];
  }
  return product < 0.0 ? -1.0 : 1.0;
}

/// What both runs leave open of a column: round-off of the machine's largest number of that unit, or what the solvers
/// differ by, as far as that is next to nothing beside it, or no more than `most`. A part of a number that is zero is
/// no error to hold them to.
double left_open(const RunsAtTimes& runs, const Column& column, double largest, double most) {
  constexpr double kNextToNothing = 1e-9;
  double difference = 0.0;
  for (std::size_t k = 0; k < runs.samples.size(); ++k) {
    const double one = value_of(column, runs.sample(0, k));
    const double other = value_of(column, runs.sample(1, k));
    difference = std::max(difference, std::abs(one - (has_free_sign(column) && one * other < 0.0 ? -other : other)));
  }
  return std::max(kRoundOff * largest, std::min(difference, std::max(most, kNextToNothing * largest)));
}

/// The largest numbers of a run by their unit, forces and torques, and what moves and what turns, by the machine's
/// length for each other; of a machine that stands still its length in the time of the run.
std::map<std::string, double> largest_numbers(const Model& model, const Trajectory& run) {
  const double length = model.length_scale();
  const double until = run.samples.back().state.t;
  std::map<std::string, double> largest{{"1", 1.0}, {"m", length}, {"rad", 1.0}, {"m/s", length / until}};
  for (const auto& columns : {reaction_columns(model), element_columns(model), motion_columns(model)}) {
    for (const Column& column : columns) {
      double& size = largest[column.unit];
      for (const Sample& sample : run.samples) size = std::max(size, std::abs(value_of(column, sample)));
    }
  }
  const std::array<std::array<const char*, 2>, 3> pairs{{{"m/s", "rad/s"}, {"m/s2", "rad/s2"}, {"N m", "N"}}};
  for (const auto& [along, about] : pairs) {
    double& one = largest[along];
    double& other = largest[about];
    one = std::max(one, length * other);
    other = std::max(other, one / length);
  }
  return largest;
}

/// Fills in how far both solvers are off, where, and whether that is allowed.
void measure_row(const RunsAtTimes& runs, const Reference& reference, const ReferenceColumn& column, bool is_judged,
                 ReferenceRow& row) {
  double worst = -1.0;
  for (std::size_t k = 0; k < column.values.size(); ++k) {
    for (std::size_t who = 0; who < 2; ++who) {
      const double said = sign_of(runs, who, k, reference, column.column) * column.values[k];
      const double difference = std::abs(value_of(column.column, runs.sample(who, k)) - said);
      row.differences[who] = std::max(row.differences[who], difference);
      if (difference <= worst) continue;
      worst = difference;
      row.t = reference.times[k];
      row.stated = said;
      row.line = reference.lines[k];
    }
    row.peak = std::max(row.peak, std::abs(column.values[k]));
  }
  row.word = !is_judged             ? ReferenceWord::not_judged
             : worst <= row.allowed ? ReferenceWord::equal
                                    : ReferenceWord::wrong;
}

/// What a picture shows of a column, whether it is judged or not.
void keep_for_pictures(const Reference& reference, const ReferenceColumn& column, ReferenceRow& row) {
  const auto quantity = quantity_of(column.column);
  const bool is_drawn = quantity && (quantity->kind == Kind::reaction || quantity->kind == Kind::element);
  if (!is_drawn || column.column.is_own || column.is_re_expressed) return;
  row.quantity = quantity;
  for (std::size_t k = 0; k < column.values.size(); ++k) {
    if (std::isnan(column.values[k])) continue;
    row.times.push_back(reference.times[k]);
    row.values.push_back(column.values[k]);
  }
}

/// Whether a reference says a number at time `k` that is not unique for both solvers.
bool may_be_many(std::size_t k, const Standard& standard, const ReferenceColumn& said) {
  return !std::isnan(said.values[k]) && !said.column.is_own && std::isnan(value_of(said.column, *standard.known[k]));
}

/// What is left of `differences` by that sum of `moves` whose largest rest is about the smallest there is: least
/// squares with weights that grow where more is left (Lawson 1961). Ends where the largest is at most 1, or cannot be.
VecX smallest_rest(const MatX& moves, const VecX& differences) {
  constexpr int kRounds = 60;
  VecX weights = VecX::Constant(differences.size(), 1.0 / static_cast<double>(differences.size()));
  VecX best;
  for (int round = 0; round < kRounds; ++round) {
    const VecX roots = weights.cwiseSqrt();
    const MatX weighted = roots.asDiagonal() * moves;
    const VecX rest = differences - moves * smallest_least_squares(weighted, roots.cwiseProduct(differences));
    const double largest = rest.cwiseAbs().maxCoeff();
    if (best.size() == 0 || largest < best.cwiseAbs().maxCoeff()) best = rest;
    const double least = rest.cwiseProduct(roots).norm();  // none has a smaller largest rest
    if (largest <= 1.0 || least > 1.0) break;
    weights = weights.cwiseProduct(rest.cwiseAbs());
    if (!(weights.sum() > 0.0)) break;
    weights /= weights.sum();
  }
  return best;
}

/// What no self-stress explains of the differences at time `k`: a number for each column, in its error; NaN for a
/// column that is unique there, or moved by none.
VecX unexplained_at(std::size_t k, const Standard& standard, const Reference& reference,
                    const std::vector<ReferenceRow>& rows) {
  constexpr double kMoved = 1e-9;  // of what is moved most
  const auto columns = static_cast<Eigen::Index>(reference.columns.size());
  const std::vector<Sample>& members = standard.self_stresses[k];
  MatX moves = MatX::Zero(columns, static_cast<Eigen::Index>(members.size()));
  VecX differences = VecX::Zero(columns);
  VecX sizes = VecX::Zero(columns);
  for (Eigen::Index c = 0; c < columns; ++c) {
    const auto index = static_cast<std::size_t>(c);
    if (!may_be_many(k, standard, reference.columns[index])) continue;
    const Column& column = reference.columns[index].column;
    const double said = reference.columns[index].values[k];
    const double unit = std::max(rows[index].allowed, std::numeric_limits<double>::min());
    for (std::size_t m = 0; m < members.size(); ++m) {
      moves(c, static_cast<Eigen::Index>(m)) = value_of(column, members[m]) / unit;
    }
    sizes(c) = moves.row(c).norm() * unit / size_of(standard, column.unit);
    differences(c) = (said - value_of(column, standard.runs.sample(0, k))) / unit;
  }
  const Eigen::Array<bool, Eigen::Dynamic, 1> is_moved = sizes.array() > kMoved * sizes.maxCoeff();
  if (!is_moved.any()) return VecX::Constant(columns, kNothing);
  for (Eigen::Index c = 0; c < columns; ++c) {
    if (is_moved(c)) continue;
    moves.row(c).setZero();
    differences(c) = 0.0;
  }
  return is_moved.select(smallest_rest(moves, differences).cwiseAbs(), kNothing);
}

/// Judges the columns where they are one of many. Returns how many numbers are neither that nor unique.
int judge_one_of_many(const Standard& standard, const Reference& reference, std::vector<ReferenceRow>& rows) {
  constexpr double kExplained = 1.1;  // of its error: the smallest rest is found to a few percent
  int left_out = 0;
  std::vector<double> most(rows.size(), kExplained);
  for (std::size_t k = 0; k < reference.times.size(); ++k) {
    const VecX unexplained = unexplained_at(k, standard, reference, rows);
    for (std::size_t c = 0; c < rows.size(); ++c) {
      const double left = unexplained(static_cast<Eigen::Index>(c));
      ReferenceRow& row = rows[c];
      if (std::isnan(left) && may_be_many(k, standard, reference.columns[c])) ++left_out;
      const bool is_wrong = row.word == ReferenceWord::wrong;
      if (std::isnan(left) || (is_wrong && most[c] == kExplained)) continue;
      if (left <= most[c]) {
        if (!is_wrong) row.word = ReferenceWord::one_of_many;
        continue;
      }
      most[c] = left;
      row.word = ReferenceWord::wrong;
      row.t = reference.times[k];
      row.line = reference.lines[k];
      row.stated = reference.columns[c].values[k];
      row.differences.fill(left * row.allowed);
      row.hint = "it is one of many there, but no self-stress explains it together with the other columns";
    }
  }
  return left_out;
}

}  // namespace

double size_of(const Standard& standard, const std::string& unit) {
  const auto found = standard.largest.find(unit);
  return found == standard.largest.end() ? 0.0 : found->second;
}

Standard standard_of(const Model& model, const Verdict& verdict, const std::vector<std::size_t>& samples,
                     const Trajectory& known) {
  const Trajectory& run = *verdict.trajectories[0];
  Standard standard{model, {verdict, samples, {}}, {}, largest_numbers(model, run), {}, {}};
  standard.self_stresses.resize(samples.size());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    for (std::size_t who = 0; who < 2; ++who) {
      standard.runs.at[who].push_back(&verdict.trajectories[who]->samples.at(samples[k]));
    }
    standard.known.push_back(&known.samples.at(samples[k]));
    if (&known == &run) continue;
    const State& state = standard.runs.sample(0, k).state;
    for (Evaluation& one : MachineConstraints(model, state).self_stresses(state)) {
      standard.self_stresses[k].push_back({state, std::move(one), 0.0});
    }
  }
  return standard;
}

Standard re_expressed(const Standard& standard, const Conventions& conventions) {
  const std::vector<Joint>& joints = standard.model.joints;
  std::vector<Convention> stated;
  for (const Joint& joint : joints) stated.push_back(stated_of(joint.name, conventions));
  if (std::none_of(stated.begin(), stated.end(), needs_re_expression)) return standard;
  const auto bring = [&](const State& state, Sample& sample) {
    for (std::size_t j = 0; j < joints.size(); ++j) {
      re_express(joints[j], stated[j], state, sample.evaluation.joints[j]);
    }
  };
  Standard other = standard;
  const std::array<std::vector<const Sample*>*, 3> all{&other.runs.at[0], &other.runs.at[1], &other.known};
  auto owned = std::make_shared<std::vector<Sample>>();
  owned->reserve(all.size() * other.known.size());  // pointers to them stay
  for (std::vector<const Sample*>* samples : all) {
    for (const Sample*& sample : *samples) {
      bring(sample->state, owned->emplace_back(*sample));
      sample = &owned->back();
    }
  }
  for (std::vector<Sample>& members : other.self_stresses) {
    for (Sample& member : members) bring(member.state, member);
  }
  other.owned = std::move(owned);
  return other;
}

JudgedRows judge_rows(const Standard& standard, const Reference& reference) {
  JudgedRows judged;
  judged.drift = drift_of(standard, reference);
  for (std::size_t k = 0; k < reference.columns.size(); ++k) {
    const ChosenTimes times = choose_times(reference, standard, k);
    const ReferenceColumn& column = times.reference.columns[times.column];
    const double largest = size_of(standard, column.column.unit);
    ReferenceRow& row = judged.rows.emplace_back();
    keep_for_pictures(reference, reference.columns[k], row);
    row.of = describe_owner(standard.model, column.column);
    row.component = describe_component(column.column);
    row.unit = column.column.unit;
    const double most = column.is_stated ? 0.0 : most_unstated(column, times.reference);
    const double error = error_of(column, standard.runs.verdict, times.reference, largest, judged.drift);
    const double open = times.is_judged ? left_open(times.runs, column.column, largest, most) : kOfSelfStress * largest;
    row.allowed = std::max(open, column.is_stated ? error : std::min(most, error + open));
    measure_row(times.runs, times.reference, column, times.is_judged, row);
  }
  judged.left_out = judge_one_of_many(standard, reference, judged.rows);
  return judged;
}

std::string hint_at_wrong(const Standard& standard, const Reference& reference, std::size_t column, double allowed) {
  const ChosenTimes times = choose_times(reference, standard, column);
  if (!times.is_judged) return "";
  return what_would_fit(standard.model, times.runs, times.reference, times.reference.columns[times.column], allowed);
}

}  // namespace concord::compare
