#include "common/reading/modes_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "common/decompositions.h"
#include "common/products.h"
#include "common/reading/magnitude.h"
#include "common/reading/model_checks.h"
#include "common/reading/text_file.h"
#include "common/reading/toml_document.h"
#include "common/reading/toml_reader.h"
#include "common/rotation.h"

namespace concord {

namespace {

constexpr int kModesFormat = 1;
constexpr int kMostModes = 1000;

/// Modal mass: the block of the modes with themselves, sum of m psi_a . psi_b, from G.
MatX modal_mass(const MatX& G, int n_modes) {
  MatX mass(n_modes, n_modes);
  for (int a = 0; a < n_modes; ++a) {
    for (int b = 0; b < n_modes; ++b) mass(a, b) = G.block<3, 3>(4 + 3 * a, 4 + 3 * b).trace();
  }
  return mass;
}

/// sum of m f_a . f_b over the 6 + m fields [translations; turns; modes] of the undeformed body, from G.
MatX products_of_fields(const MatX& G, int n_modes) {
  MatX products = MatX::Zero(6 + n_modes, 6 + n_modes);
  for (int c = 0; c < 3; ++c) {
    MatX fields = MatX::Zero(G.rows(), 6 + n_modes);  // component c over [1; s_0; psi_1; ...]
    fields(0, c) = 1.0;
    for (int turn = 0; turn < 3; ++turn) {
      fields.block<3, 1>(1, 3 + turn) = Vec3::Unit(c).cross(Vec3::Unit(turn));
    }
    for (int mode = 0; mode < n_modes; ++mode) fields(4 + 3 * mode + c, 6 + mode) = 1.0;
    products += congruence(fields, G);
  }
  return products;
}

/// Whether some combination of the modes is a rigid motion of the undeformed body to the accuracy of printed numbers.
bool hold_a_rigid_motion(const MatX& G, int n_modes) {
  constexpr double kRigid = 1e-11;  // of its kinetic energy that no rigid motion gives
  const MatX products = products_of_fields(G, n_modes);
  const MatX beside = products.topRightCorner(6, n_modes);
  const MatX left = products.bottomRightCorner(n_modes, n_modes) -
                    transposed_product(beside, smallest_least_squares(products.topLeftCorner(6, 6), beside));
  const VecX sizes = products.diagonal().tail(n_modes).cwiseSqrt().cwiseInverse();
  const MatX scaled = sizes.asDiagonal() * left * sizes.asDiagonal();
  return symmetric_eigenvalues(scaled).minCoeff() < kRigid;
}

/// Complains of a matrix that is not symmetric or, in units that compare, not positive semidefinite; true if it is
/// both.
bool check_semidefinite(const TableReader& table, std::string_view key, const MatX& matrix, const MatX& unit_free) {
  if (const auto complaint = complaint_about_symmetry(matrix)) {
    table.complain(key, fmt::format("'{}' must be symmetric, but {}", key, *complaint));
    return false;
  }
  if (const auto complaint = complaint_about_semidefiniteness(unit_free)) {
    table.complain(key, fmt::format("'{}' must be positive semidefinite, but {}", key, *complaint));
    return false;
  }
  return true;
}

/// Complains of what follows from the key's numbers if an entry overflows; true if none does.
bool check_bounded(const TableReader& table, std::string_view key, std::string_view what, const MatX& matrix) {
  if (are_bounded(matrix)) return true;
  table.complain(key, fmt::format("{} go beyond {}", what, kLargestSize));
  return false;
}

/// An m x m matrix, as rows or as the m numbers of its diagonal.
std::optional<MatX> read_square(const TableReader& table, std::string_view key, int m) {
  const toml::node* found = table.node(key);
  if (found == nullptr) return std::nullopt;
  const toml::array* list = found->as_array();
  const bool has_rows = list != nullptr && !list->empty() && list->front().is_array();
  std::optional<MatX> matrix;
  if (has_rows) {
    matrix = table.matrix(key, m, m);
  } else if (const auto diagonal = table.vector(key, m)) {
    matrix = diagonal->asDiagonal();
  }
  if (!matrix || !check_semidefinite(table, key, *matrix, *matrix)) return std::nullopt;
  return matrix;
}

/// Second moment of a rigid node about itself from its inertia tensor: tr(I)/2 1 - I.
Mat3 second_moment(const Mat3& inertia) { return 0.5 * inertia.trace() * Mat3::Identity() - inertia; }

/// Six mass points that have a node's mass, and its rotary inertia in all modes: at plus and minus c_k along the
/// principal axes of the second moment, with modes Psi_t - c_k~ Psi_r (S4).
void add_rotary_node(const MassPoint& point, const Mat3X& Psi_r_L, const Mat3& inertia,
                     std::vector<MassPoint>& points) {
  const SymmetricEigenpairs principal = symmetric_eigenpairs(second_moment(inertia));
  for (int k = 0; k < 3; ++k) {
    const double length = std::sqrt(std::max(0.0, 3.0 * principal.values(k) / point.mass));
    for (const double sign : {-1.0, 1.0}) {
      const Vec3 c = sign * length * principal.vectors.col(k);
      points.push_back({point.mass / 6.0, point.s0_L + c, point.Psi_t_L - skew(c) * Psi_r_L});
    }
  }
}

void read_mass_point(const toml::table& found, int number, int m, FileReading& reading,
                     std::vector<MassPoint>& points) {
  const TableReader table(found, fmt::format("mass point {}", number), {"mass", "point", "Psi_t", "inertia", "Psi_r"},
                          reading);
  table.require({"mass", "point", "Psi_t"});
  const auto mass = table.positive_number("mass");
  const auto place = table.vector3("point");
  const auto Psi_t = table.matrix("Psi_t", 3, m);
  if (!table.has("inertia") && !table.has("Psi_r")) {
    if (mass && place && Psi_t) points.push_back({*mass, *place, *Psi_t});
    return;
  }
  if (!table.require({"inertia", "Psi_r"})) return;
  const auto elements = table.vector("inertia", 6);
  const auto Psi_r = table.matrix("Psi_r", 3, m);
  if (!mass || !place || !Psi_t || !elements || !Psi_r) return;
  const VecX& I = *elements;
  Mat3 inertia;
  inertia << I(0), I(3), I(4), I(3), I(1), I(5), I(4), I(5), I(2);
  if (const auto complaint = complaint_about_inertia(inertia)) {
    table.complain("inertia", fmt::format("'inertia' has {}", *complaint));
    return;
  }
  add_rotary_node({*mass, *place, *Psi_t}, *Psi_r, inertia, points);
}

std::optional<MatX> read_integrals(const TableReader& document, int m) {
  const int size = 4 + 3 * m;
  const toml::array* rows = document.node("inertia_integrals")->as_array();
  if (rows != nullptr && rows->size() != static_cast<std::size_t>(size)) {
    document.complain("inertia_integrals",
                      fmt::format("'inertia_integrals' must be all of G, {0} x {0} for {1} modes, found {2} rows: from "
                                  "an incomplete set the inertia does not follow",
                                  size, m, rows->size()));
    return std::nullopt;
  }
  auto G = document.matrix("inertia_integrals", size, size);
  if (!G || !check_semidefinite(document, "inertia_integrals", *G, without_units(*G))) return std::nullopt;
  if ((*G)(0, 0) > 0.0) return G;
  document.complain("inertia_integrals", fmt::format("the mass, entry (1, 1), must be positive, found {}", (*G)(0, 0)));
  return std::nullopt;
}

/// Mass points and G from whichever of the two the file gives; true if they could be read.
bool read_inertia(const TableReader& document, int m, ModalData& data) {
  if (!document.require_one_of({"mass_point", "inertia_integrals"})) return false;
  const std::size_t complaints_before = document.reading().complaints.size();
  if (document.has("inertia_integrals")) {
    const auto G = read_integrals(document, m);
    if (!G) return false;
    data.G = *G;
    data.mass_points = equivalent_mass_points(*G);
    const bool are_all_bounded =
        std::all_of(data.mass_points.begin(), data.mass_points.end(),
                    [](const MassPoint& point) { return are_bounded(point.s0_L) && are_bounded(point.Psi_t_L); });
    if (!are_all_bounded) document.complain("inertia_integrals", "the mass is too small for its moments");
    return are_all_bounded;
  }
  int number = 0;
  for (const toml::table* table : document.tables("mass_point")) {
    read_mass_point(*table, ++number, m, document.reading(), data.mass_points);
  }
  if (document.reading().complaints.size() != complaints_before) return false;
  data.G = mass_integrals(data.mass_points, m);
  return check_bounded(document, "mass_point", "the mass integrals", data.G);
}

void read_nodes(const TableReader& document, int m, std::vector<ModalNode>& nodes) {
  document.require({"node"});
  for (const toml::table* found : document.tables("node")) {
    const TableReader table(*found, "node", {"name", "point", "Psi_t", "Psi_r"}, document.reading());
    table.require({"point", "Psi_t", "Psi_r"});
    ModalNode node;
    node.name = table.name();
    node.s0_L = table.vector3("point").value_or(node.s0_L);
    node.Psi_t_L = table.matrix("Psi_t", 3, m).value_or(MatX::Zero(3, m));
    node.Psi_r_L = table.matrix("Psi_r", 3, m).value_or(MatX::Zero(3, m));
    const bool is_taken =
        std::any_of(nodes.begin(), nodes.end(), [&](const ModalNode& other) { return other.name == node.name; });
    if (is_taken) table.complain("name", fmt::format("two nodes have the name '{}'", node.name));
    nodes.push_back(std::move(node));
  }
}

std::optional<VecX> read_damping_ratios(const TableReader& document, int m) {
  auto ratios = document.vector("damping_ratios", m);
  if (!ratios || ratios->minCoeff() >= 0.0) return ratios;
  document.complain("damping_ratios",
                    fmt::format("a damping ratio must not be negative, found {}", ratios->minCoeff()));
  return std::nullopt;
}

/// Whether no mode is a combination of the others, whatever the lengths to which they are scaled.
bool are_independent(const MatX& modal_mass) {
  constexpr double kIndependent = 1e-12;
  const VecX sizes = modal_mass.diagonal().cwiseMax(0.0).cwiseSqrt();
  if (!(sizes.minCoeff() > 0.0)) return false;
  const VecX scales = sizes.cwiseInverse();
  return symmetric_eigenvalues(scales.asDiagonal() * modal_mass * scales.asDiagonal()).minCoeff() > kIndependent;
}

/// Frequencies from stiffness and modal mass, and the damping: given, by ratios of the undamped modes in order of
/// frequency (D = M Phi diag(2 zeta omega) Phi^T M), or none.
void add_frequencies_and_damping(const TableReader& document, ModalData& data) {
  const int m = data.n_modes();
  data.damping = MatX::Zero(m, m);
  const MatX mass = modal_mass(data.G, m);
  if (!are_independent(mass)) {
    document.complain("the modes are not independent: their modal mass is singular");
    return;
  }
  if (hold_a_rigid_motion(data.G, m)) {
    document.complain("the modes move the body as a whole, which its frame does already: leave rigid-body modes out");
    return;
  }
  const auto modes = symmetric_eigenpairs(data.stiffness, mass);
  if (!modes) {
    document.complain("the modes are not independent: their modal mass is not positive definite");
    return;
  }
  data.frequencies = modes->values.cwiseMax(0.0).cwiseSqrt();
  if (document.has("damping") && document.has("damping_ratios")) {
    document.require_one_of({"damping", "damping_ratios"});
  } else if (document.has("damping")) {
    data.damping = read_square(document, "damping", m).value_or(data.damping);
  } else if (const auto ratios = read_damping_ratios(document, m)) {
    const MatX shapes = product(mass, modes->vectors);
    data.damping = product(shapes * (2.0 * ratios->cwiseProduct(data.frequencies)).asDiagonal(), shapes.transpose());
    check_bounded(document, "damping_ratios", "the damping's entries", data.damping);
  }
}

std::string rows_text(const MatX& matrix) {
  std::vector<std::string> rows;
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    const Eigen::RowVectorXd numbers = matrix.row(row);
    rows.push_back(fmt::format("[{}]", fmt::join(numbers.begin(), numbers.end(), ", ")));
  }
  return fmt::format("[{}]", fmt::join(rows, ", "));
}

std::string vector_text(const Vec3& v) { return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z()); }

}  // namespace

ModalData parse_modes(std::string_view text, const std::filesystem::path& file) {
  FileReading reading;
  reading.file = file.generic_string();
  const toml::table root = parse_toml(text, reading.file);
  const TableReader document(
      root, "",
      {"format", "modes", "stiffness", "damping", "damping_ratios", "inertia_integrals", "mass_point", "node"},
      reading);
  check_format(document, kModesFormat);
  document.require({"modes", "stiffness"});
  ModalData data;
  if (const auto m = document.count("modes", 1, kMostModes)) {
    const auto stiffness = read_square(document, "stiffness", *m);
    data.stiffness = stiffness ? *stiffness : MatX::Zero(*m, *m);
    const bool has_inertia = read_inertia(document, *m, data);
    read_nodes(document, *m, data.nodes);
    if (stiffness && has_inertia) add_frequencies_and_damping(document, data);
  }
  reading.throw_if_any();
  return data;
}

ModalData read_modes_file(const std::filesystem::path& file) { return parse_modes(read_text_file(file), file); }

std::string format_modes(const ModalData& data, InertiaForm form) {
  std::string text = fmt::format("format = {}\nmodes = {}\nstiffness = {}\ndamping = {}\n", kModesFormat,
                                 data.n_modes(), rows_text(data.stiffness), rows_text(data.damping));
  if (form == InertiaForm::integrals) {
    text += fmt::format("inertia_integrals = {}\n", rows_text(data.G));
  } else {
    for (const MassPoint& point : data.mass_points) {
      text += fmt::format("\n[[mass_point]]\nmass = {}\npoint = {}\nPsi_t = {}\n", point.mass, vector_text(point.s0_L),
                          rows_text(point.Psi_t_L));
    }
  }
  for (const ModalNode& node : data.nodes) {
    text += fmt::format("\n[[node]]\nname = \"{}\"\npoint = {}\nPsi_t = {}\nPsi_r = {}\n", node.name,
                        vector_text(node.s0_L), rows_text(node.Psi_t_L), rows_text(node.Psi_r_L));
  }
  return text;
}

}  // namespace concord
