#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "common/decompositions.h"
#include "tests/second_reading/bodies.h"
#include "tests/second_reading/stated_file.h"

namespace concord::second_reading {

namespace {

/// Sums over mass points and eigenvectors leave this of themselves.
constexpr double kRoundOffOfSums = 1e-9;

/// G as a product of two lists of columns: one product of matrices is far faster than a sum over points.
struct Factors {
  std::vector<VecX> left;
  std::vector<VecX> right;

  void add(const VecX& w, const VecX& v) {
    left.push_back(w);
    right.push_back(v);
  }
  [[nodiscard]] MatX product(Eigen::Index size) const {
    const auto count = static_cast<Eigen::Index>(left.size());
    MatX W(size, count);
    MatX V(size, count);
    for (Eigen::Index k = 0; k < count; ++k) {
      W.col(k) = left[static_cast<std::size_t>(k)];
      V.col(k) = right[static_cast<std::size_t>(k)];
    }
    return W * V.transpose();
  }
};

/// w = [1; s_0; psi_1; ...; psi_m] of a point.
VecX places_of(const Vec3& point, const MatX& shapes) {
  VecX w(4 + shapes.size());
  w << 1.0, point, Eigen::Map<const VecX>(shapes.data(), shapes.size());
  return w;
}

/// Adds what a mass point, or a rigid lump of inertia, has in G: with S = sum of m x x^T about the point, which is half
/// the trace of the inertia less the inertia, and a lump that turns with Psi_r.
void add_point(const StatedTable& point, Factors& G) {
  const double mass = point.number("mass").value();
  const MatX shapes = point.matrix("Psi_t").value();
  const VecX w = places_of(point.vector("point").value(), shapes);
  G.add(w, mass * w);
  const auto inertia = point.numbers("inertia");
  const auto turns = point.matrix("Psi_r");
  if (!inertia || !turns) return;
  const Mat3 tensor = tensor_of(*inertia);
  const Mat3 S = 0.5 * tensor.trace() * Mat3::Identity() - tensor;
  MatX D = MatX::Zero(w.size(), 3);
  for (int axis = 0; axis < 3; ++axis) {
    D(1 + axis, axis) = 1.0;
    for (Eigen::Index k = 0; k < turns->cols(); ++k) {
      D.block<3, 1>(4 + 3 * k, axis) = Vec3(turns->col(k)).cross(Vec3::Unit(axis));
    }
  }
  for (int axis = 0; axis < 3; ++axis) G.add(D.col(axis), D * S.col(axis));
}

/// Sum of m w w^T of the points that the model has.
MatX integrals_of(const std::vector<MassPoint>& points, Eigen::Index size) {
  Factors G;
  for (const MassPoint& point : points) {
    const VecX w = places_of(point.s0_L, point.Psi_t_L);
    if (w.size() != size) return {};
    G.add(w, point.mass * w);
  }
  return G.product(size);
}

/// Each entry against the product of the sizes of its row and its column.
void hold_by_sizes(Ledger& ledger, const Entry& entry, const MatX& read, const MatX& stated, const VecX& sizes,
                   double allowed) {
  if (read.rows() != stated.rows() || read.cols() != stated.cols()) {
    ledger.numbers(entry, read, stated);
    return;
  }
  const MatX scales = sizes * sizes.transpose();
  ledger.numbers(entry, read.cwiseQuotient(scales), stated.cwiseQuotient(scales), allowed, 1.0);
}

/// Entries of G have units of their own: the sizes are those of the mass, of all places and of all that a mode moves.
void hold_integrals(Ledger& ledger, const Entry& entry, const MatX& read, const MatX& stated, double allowed) {
  VecX sizes = VecX::Constant(stated.rows(), std::sqrt(stated(0, 0)));
  for (Eigen::Index k = 1; k < stated.rows(); k += 3) {
    const double size = std::sqrt(stated.diagonal().segment<3>(k).sum());
    if (size > 0.0) sizes.segment<3>(k).setConstant(size);
  }
  hold_by_sizes(ledger, entry, read, stated, sizes, allowed);
}

/// Numbers of pairs of modes: the sizes are the roots of the diagonal, as far as that is known.
void hold_of_modes(Ledger& ledger, const Entry& entry, const MatX& read, const MatX& stated) {
  constexpr double kKnown = 1e-12;
  const double largest = stated.cwiseAbs().maxCoeff();
  VecX sizes = stated.diagonal().cwiseMax(kKnown * largest).cwiseSqrt();
  if (!(largest > 0.0)) sizes.setOnes();
  hold_by_sizes(ledger, entry, read, stated, sizes, kRoundOff);
}

MatX symmetric_part_of(const MatX& A) { return 0.5 * (A + A.transpose()); }

/// Frequencies and mass-normalized shapes of the undamped modes, the body's frame at rest.
struct UndampedModes {
  VecX frequencies;
  MatX shapes;
  MatX mass;
};

UndampedModes undamped_modes_of(const MatX& G, const MatX& stiffness) {
  const Eigen::Index m = stiffness.rows();
  UndampedModes modes{VecX(m), MatX(m, m), MatX(m, m)};
  for (Eigen::Index k = 0; k < m; ++k) {
    for (Eigen::Index l = 0; l < m; ++l) modes.mass(k, l) = G.block<3, 3>(4 + 3 * k, 4 + 3 * l).trace();
  }
  const std::optional<SymmetricEigenpairs> pairs = symmetric_eigenpairs(stiffness, modes.mass);
  if (!pairs) throw std::runtime_error("modes without mass");
  modes.frequencies = pairs->values.cwiseMax(0.0).cwiseSqrt();
  modes.shapes = pairs->vectors;
  return modes;
}

/// What round-off leaves open of 2 zeta omega: an omega near zero is a root of round-off, and modes of almost the same
/// frequency mix.
VecX doubts_of(const VecX& ratios, const VecX& frequencies) {
  constexpr double kKnown = 1e-13;
  const double largest = frequencies.maxCoeff();
  VecX doubts(frequencies.size());
  for (Eigen::Index k = 0; k < frequencies.size(); ++k) {
    doubts(k) = 2.0 * ratios(k) * largest * std::min(std::sqrt(kKnown), kKnown * largest / frequencies(k));
    for (Eigen::Index l = 0; l < frequencies.size(); ++l) {
      const double gap = std::abs(frequencies(k) - frequencies(l)) / largest;
      const double apart = 2.0 * std::abs(ratios(k) * frequencies(k) - ratios(l) * frequencies(l));
      if (l != k && apart > 0.0) doubts(k) += apart * std::min(1.0, kKnown / gap);
    }
  }
  return doubts;
}

void hold_damping(const ModalData& modal, const StatedTable& top, const UndampedModes& modes) {
  const auto list = top.numbers("damping_ratios");
  if (!list) {
    const MatX none = MatX::Zero(modes.mass.rows(), modes.mass.cols());
    hold_of_modes(top.ledger(), top.entry("damping"), modal.damping,
                  symmetric_part_of(top.matrix("damping").value_or(none)));
    return;
  }
  const VecX ratios = column_of(*list);
  if (ratios.size() != modes.frequencies.size()) throw std::runtime_error("damping_ratios: not one for each mode");
  const MatX across = modes.mass * modes.shapes;
  const MatX stated = 2.0 * across * ratios.cwiseProduct(modes.frequencies).asDiagonal() * across.transpose();
  const MatX doubt =
      across.cwiseAbs() * doubts_of(ratios, modes.frequencies).asDiagonal() * across.cwiseAbs().transpose();
  constexpr double kKnown = 1e-4;  // what eigenvectors leave open is none of the reading's: it is held to four digits
  const double largest = stated.cwiseAbs().maxCoeff();
  if (!(doubt.maxCoeff() < kKnown * largest)) return;
  top.ledger().numbers(top.entry("damping_ratios"), modal.damping, stated, kKnown, largest);
}

void hold_nodes(const ModalData& modal, const StatedTable& top, const std::string& where) {
  const std::vector<StatedTable> stated = top.tables("node");
  Ledger& ledger = top.ledger();
  ledger.number(top.entry("node"), static_cast<double>(modal.nodes.size()), static_cast<double>(stated.size()));
  for (const StatedTable& node : stated) {
    const std::string name = node.text("name").value_or("");
    node.rename(fmt::format("{}, node {}", where, name));
    const ModalNode* read = nullptr;
    for (const ModalNode& one : modal.nodes) {
      if (one.name == name) read = &one;
    }
    const MatX Psi_t = node.matrix("Psi_t").value();
    const MatX Psi_r = node.matrix("Psi_r").value();
    const Vec3 point = node.vector("point").value();
    if (!ledger.both_have(node.entry("name"), read != nullptr, true)) continue;
    ledger.numbers(node.entry("point"), read->s0_L, point);
    ledger.numbers(node.entry("Psi_t"), read->Psi_t_L, Psi_t);
    ledger.numbers(node.entry("Psi_r"), read->Psi_r_L, Psi_r);
  }
}

/// Gives all of G as the file states it.
MatX hold_mass(const ModalData& modal, const StatedTable& top, int m) {
  const auto integrals = top.matrix("inertia_integrals");
  Factors factors;
  for (const StatedTable& point : top.tables("mass_point")) add_point(point, factors);
  MatX G = integrals ? symmetric_part_of(*integrals) : factors.product(4 + 3 * m);
  const Entry entry = top.entry(integrals ? "inertia_integrals" : "mass_point");
  hold_integrals(top.ledger(), entry, modal.G, G, integrals ? kRoundOff : 1e-11);
  Entry of_points = entry;
  of_points.key += " (as mass points)";
  hold_integrals(top.ledger(), of_points, integrals_of(modal.mass_points, G.rows()), G, kRoundOffOfSums);
  return G;
}

}  // namespace

void hold_modes_file(const Body& body, const StatedTable& table) {
  const ModalData& modal = *body.modal;
  Ledger& ledger = table.ledger();
  const std::filesystem::path path = table.file().path.parent_path() / table.text("modes_file").value();
  const auto file = open_file(path, ledger);
  const StatedTable& top = *file->top;
  top.rename(table.where());
  if (top.number("format") != 1.0) throw std::runtime_error("no modes file of format 1");
  const int m = static_cast<int>(top.number("modes").value());
  ledger.number(top.entry("modes"), modal.n_modes(), m);
  const MatX G = hold_mass(modal, top, m);
  const MatX stiffness = symmetric_part_of(top.matrix("stiffness").value());
  hold_of_modes(ledger, top.entry("stiffness"), modal.stiffness, stiffness);
  const UndampedModes modes = undamped_modes_of(G, stiffness);
  hold_damping(modal, top, modes);
  if (modal.frequencies.size() > 0) {
    ledger.numbers(top.entry("frequencies"), modal.frequencies.cwiseAbs2(), modes.frequencies.cwiseAbs2(),
                   kRoundOffOfSums);
  }
  hold_nodes(modal, top, table.where());
}

}  // namespace concord::second_reading
