#include <algorithm>
#include <map>
#include <utility>

#include "compare/analyses/branch.h"

namespace concord::compare::analyses {

namespace {

/// Splits the equations as they are solved one after the other: bodies on driven joints from the ground on, speeds of
/// joints between two bodies that move as is known; then what is left, part by part where parts share no unknown.
class Blocks {
 public:
  explicit Blocks(const Model& model) : n_bodies_(model.bodies.size() - 1) {
    add_unknowns(model);
    add_equations(model);
  }

  std::vector<Block> split() {
    while (solve_some()) {
    }
    add_parts();
    return std::move(blocks_);
  }

 private:
  /// Columns of one body, or that of one speed.
  struct Unknown {
    Eigen::Index first;
    Eigen::Index count;
    bool is_known = false;
    std::size_t part = 0;
  };
  struct Equations {
    Eigen::Index first;
    Eigen::Index count;
    std::vector<std::size_t> unknowns;
    bool is_used = false;
  };

  void add_unknowns(const Model& model) {
    Eigen::Index column = 0;
    const auto add = [&](Eigen::Index count) {
      unknowns_.push_back({column, count});
      column += count;
    };
    for (std::size_t i = 0; i < n_bodies_; ++i) add(6);
    for (const Joint& joint : model.joints) {
      first_speed_.push_back(unknowns_.size());
      for (int u = 0; u < joint.type->n_u(); ++u) add(1);
    }
  }

  void add_equations(const Model& model) {
    Eigen::Index row = 0;
    const auto add = [&](Eigen::Index count, std::vector<std::size_t> unknowns) {
      equations_.push_back({row, count, std::move(unknowns)});
      row += count;
    };
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      std::vector<std::size_t> unknowns;
      for (const Side side : kSides) {
        const int body = model.joints[k].on(side).body;
        if (body != kGround) unknowns.push_back(static_cast<std::size_t>(body - 1));
      }
      for (int u = 0; u < model.joints[k].type->n_u(); ++u) unknowns.push_back(speed(k, u));
      add(6, std::move(unknowns));
    }
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      for (const Driver& driver : model.joints[k].drivers) {
        add(1, {speed(k, first_u(*model.joints[k].type, driver.word) + driver.component)});
      }
    }
    for (const Coupling& coupling : model.couplings) {
      std::vector<std::size_t> unknowns;
      for (const CouplingTerm& term : coupling.terms) {
        const auto k = static_cast<std::size_t>(term.joint);
        unknowns.push_back(speed(k, first_u(*model.joints[k].type, term.word) + term.component));
      }
      add(1, std::move(unknowns));
    }
  }

  [[nodiscard]] std::size_t speed(std::size_t joint, int u) const {
    return first_speed_[joint] + static_cast<std::size_t>(u);
  }

  [[nodiscard]] std::vector<std::size_t> unknowns_left(const Equations& equations) const {
    std::vector<std::size_t> left;
    for (const std::size_t i : equations.unknowns) {
      if (!unknowns_[i].is_known && std::find(left.begin(), left.end(), i) == left.end()) left.push_back(i);
    }
    return left;
  }

  static void append(Eigen::Index first, Eigen::Index count, std::vector<Eigen::Index>& places) {
    for (Eigen::Index k = 0; k < count; ++k) places.push_back(first + k);
  }

  /// Whether some equations were found that hold all that is not known in them.
  bool solve_some() {
    bool has_solved = false;
    for (Equations& equations : equations_) {
      if (equations.is_used) continue;
      const std::vector<std::size_t> left = unknowns_left(equations);
      const auto is_body = [this](std::size_t i) { return i < n_bodies_; };
      const bool has_body = std::any_of(left.begin(), left.end(), is_body);
      if (has_body ? left.size() > 1 : static_cast<Eigen::Index>(left.size()) > equations.count) continue;
      equations.is_used = has_solved = true;
      if (left.empty()) continue;
      Block& block = blocks_.emplace_back();
      append(equations.first, equations.count, block.rows);
      for (const std::size_t i : left) {
        append(unknowns_[i].first, unknowns_[i].count, block.columns);
        unknowns_[i].is_known = true;
      }
    }
    return has_solved;
  }

  void add_parts() {
    for (std::size_t i = 0; i < unknowns_.size(); ++i) unknowns_[i].part = i;
    for (const Equations& equations : equations_) {
      const std::vector<std::size_t> left = equations.is_used ? std::vector<std::size_t>{} : unknowns_left(equations);
      for (const std::size_t i : left) {
        const std::size_t from = unknowns_[i].part;
        for (Unknown& unknown : unknowns_) {
          if (unknown.part == from) unknown.part = unknowns_[left.front()].part;
        }
      }
    }
    std::map<std::size_t, Block> parts;
    for (const Unknown& unknown : unknowns_) {
      if (!unknown.is_known) append(unknown.first, unknown.count, parts[unknown.part].columns);
    }
    for (const Equations& equations : equations_) {
      if (equations.is_used) continue;
      append(equations.first, equations.count, parts[unknowns_[unknowns_left(equations).front()].part].rows);
    }
    for (auto& [part, block] : parts) blocks_.push_back(std::move(block));
  }

  std::size_t n_bodies_;
  std::vector<Unknown> unknowns_;  // bodies 1, 2, ..., then speeds
  std::vector<std::size_t> first_speed_;
  std::vector<Equations> equations_;
  std::vector<Block> blocks_;
};

}  // namespace

std::vector<Block> block_triangular_form(const Model& model) { return Blocks(model).split(); }

}  // namespace concord::compare::analyses
