#include "common/reading/magnitude.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <utility>

#include "common/overloaded.h"

namespace concord {

namespace {

/// Largest sizes of a law of time and of its rate.
struct LawSizes {
  double value = 0.0;
  double rate = 0.0;
};

double worst_of(double first, double second) { return std::isnan(second) ? second : std::max(first, second); }

LawSizes sizes_of(const TimeFunction& law, double until) {
  return std::visit(
      Overloaded{
          [&](const ConstantSpeed& one) {
            return LawSizes{std::abs(one.start) + std::abs(one.speed) * until, std::abs(one.speed)};
          },
          [&](const Polynomial& one) {
            LawSizes sizes;
            double power = 1.0;  // until^(k - 1)
            for (std::size_t k = 0; k < one.coefficients.size(); ++k) {
              const double size = std::abs(one.coefficients[k]);
              if (k == 0 || size == 0.0) {
                sizes.value += size;
              } else {
                sizes.value += size * power * until;
                sizes.rate += static_cast<double>(k) * size * power;
              }
              if (k > 0) power *= until;
            }
            return sizes;
          },
          [](const Harmonic& one) {
            return LawSizes{std::abs(one.offset) + std::abs(one.amplitude), std::abs(one.amplitude * one.frequency)};
          },
          [](const SmoothStep& one) {
            return LawSizes{std::max(std::abs(one.from), std::abs(one.to)),
                            2.2 * std::abs(one.to - one.from) / (one.t1 - one.t0)};
          },
          [](const SplineTable& one) {
            LawSizes sizes;
            for (const double t : one.times()) {
              const TimeFunctionValue at = one.evaluate(t);
              sizes.value = worst_of(sizes.value, std::abs(at.f));
              sizes.rate = worst_of(sizes.rate, std::abs(at.fdot));
            }
            return sizes;
          }},
      law);
}

/// Largest size of a law's second derivative.
double size_of_second_derivative(const TimeFunction& law, double until) {
  return std::visit(
      Overloaded{[](const ConstantSpeed& /*one*/) { return 0.0; },
                 [&](const Polynomial& one) {
                   double size = 0.0;
                   double power = 1.0;  // until^(k - 2)
                   for (std::size_t k = 2; k < one.coefficients.size(); ++k, power *= until) {
                     if (one.coefficients[k] == 0.0) continue;
                     size += static_cast<double>(k * (k - 1)) * std::abs(one.coefficients[k]) * power;
                   }
                   return size;
                 },
                 [](const Harmonic& one) { return std::abs(one.amplitude * one.frequency) * std::abs(one.frequency); },
                 [](const SmoothStep& one) {
                   const double length = one.t1 - one.t0;
                   return 7.6 * std::abs(one.to - one.from) / length / length;
                 },
                 [](const SplineTable& one) {
                   double size = 0.0;
                   for (const double t : one.times()) {
                     size = worst_of(size, std::abs(one.evaluate(t).fddot));
                   }
                   return size;
                 }},
      law);
}

/// The decimal exponent of a size; minus infinity of zero.
double exponent_of(double size) { return std::log10(std::abs(size)); }

double largest_entry(const MatX& matrix) { return matrix.size() == 0 ? 0.0 : matrix.cwiseAbs().maxCoeff(); }

bool is_length(const elements::Dimension& of) { return of.force == 0 && of.length == 1 && of.time == 0; }
bool is_speed(const elements::Dimension& of) { return of.force == 0 && of.length == 1 && of.time == -1; }

/// Decimal exponents of the largest sizes in a machine.
class MachineSizes {
 public:
  explicit MachineSizes(const Model& model) : until_(model.run.until) {
    gravity = exponent_of(model.gravity.norm());
    for (const Body& body : model.bodies) add(body);
    for (const Joint& joint : model.joints) add(joint);
    for (const ForceElement& element : model.elements) add(element);
    speed = std::max(speed, turn_rate + length);
  }

  [[nodiscard]] double until() const { return until_; }

  double length = exponent_of(0.0);     // m
  double turn_rate = exponent_of(0.0);  // rad/s
  double speed = exponent_of(0.0);      // m/s
  double gravity = exponent_of(0.0);    // m/s2

 private:
  static void grow(double& exponent, double size) { exponent = std::max(exponent, exponent_of(size)); }

  void add(const Body& body) {
    grow(length, body.center_of_mass_L.norm());
    if (body.pose_guess) grow(length, body.pose_guess->r.norm());
    if (!body.modal) return;
    for (const MassPoint& point : body.modal->mass_points) {
      grow(length, point.s0_L.norm());
      grow(length, largest_product(point.Psi_t_L, body.a_start));
      grow(speed, largest_product(point.Psi_t_L, body.adot_start));
    }
    for (const ModalNode& node : body.modal->nodes) grow(length, node.s0_L.norm());
  }

  static double largest_product(const Mat3X& Psi, const VecX& a) {
    return a.size() == 0 ? 0.0 : largest_entry(Psi) * largest_entry(a);
  }

  void add(const Joint& joint) {
    for (const Attachment& side : joint.sides) grow(length, side.point_L.norm());
    for (std::size_t word = 0; word < joint.start.size(); ++word) {
      const joints::Permit& permit = joint.type->permits[word];
      grow(length, joints::stated_length(permit));
      const WordStart& start = joint.start[word];
      for (Eigen::Index k = 0; k < start.u.size(); ++k) {
        const bool slides = joints::is_length(permit, static_cast<int>(k));
        grow(slides ? speed : turn_rate, start.u(k));
        if (slides && k < start.q.size()) grow(length, start.q(k));
      }
    }
    for (const Driver& driver : joint.drivers) {
      const LawSizes sizes = sizes_of(driver.law, until_);
      const bool slides =
          joints::is_length(joint.type->permits[static_cast<std::size_t>(driver.word)], driver.component);
      grow(slides ? speed : turn_rate, sizes.rate);
      if (slides) grow(length, sizes.value);
    }
  }

  void add(const ForceElement& element) {
    for (const Side side : {Side::parent, Side::child}) {
      if (const Attachment* end = end_of(element, side)) grow(length, end->point_L.norm());
    }
    each_quantity(element, Overloaded{elements::IgnoreQuantity{},
                                      [&](const elements::Scalar<const double>& number) {
                                        if (is_length(number.of)) grow(length, number.value);
                                      },
                                      [&](const elements::LawOverCoordinate<const ForceLaw>& spring) {
                                        if (spring.over_length) grow(length, spring.value.free);
                                      }});
  }

  double until_;
};

/// Products of one owner, reported at its location.
class ProductChecks {
 public:
  ProductChecks(std::string owner, const SourceLocation& where, std::vector<Diagnostic>& complaints)
      : owner_(std::move(owner)), where_(where), complaints_(complaints) {}

  /// Exponents of the factors are summed; a product with a factor of zero is zero. Reports the first complaint only.
  void check(std::string_view what, double exponent) {
    static const double kMost = exponent_of(kLargestSize);
    if (told_ || exponent <= kMost) return;
    tell(fmt::format("{} is of the size 1e{:+.0f}, beyond 1e{:+.0f}", what, exponent, kMost));
  }

  /// The same for a product that must not vanish either.
  void check_both(std::string_view what, double exponent) {
    static const double kLeast = exponent_of(kSmallestSize);
    check(what, exponent);
    if (told_ || std::isinf(exponent) || exponent >= kLeast) return;
    tell(fmt::format("{} is of the size 1e{:+.0f}, below 1e{:+.0f}", what, exponent, kLeast));
  }

 private:
  void tell(const std::string& found) {
    told_ = true;
    complaints_.push_back({where_, fmt::format("{}: {}: choose units in which it is nearer to one", owner_, found)});
  }

  std::string owner_;
  SourceLocation where_;
  std::vector<Diagnostic>& complaints_;
  bool told_ = false;
};

/// What a force law does over a coordinate of the size x at the rate xdot, both as exponents.
void check_law(const ForceLaw& law, double x, double xdot, double until, ProductChecks& products) {
  x = std::max(x, exponent_of(law.free));
  products.check("stiffness times the square of its stretch", exponent_of(law.stiffness) + 2.0 * x);
  products.check("damping times stretch and rate", exponent_of(law.damping) + x + xdot);
  products.check("preload times stretch", exponent_of(law.preload) + x);
  for (const auto* stop : {&law.lower, &law.upper}) {
    if (!*stop) continue;
    const double reach = std::max(x, exponent_of((*stop)->at));
    products.check("a stop's stiffness times the square of its stretch", exponent_of((*stop)->stiffness) + 2.0 * reach);
    products.check("a stop's damping times stretch and rate", exponent_of((*stop)->damping) + reach + xdot);
    products.check("a stop's damping times rate over its width",
                   exponent_of((*stop)->damping) + xdot - exponent_of((*stop)->width));
  }
  if (law.spring_table) {
    products.check("the spring table's slope times the square of the stretch",
                   exponent_of(law.spring_table->slope(0.0)) + 2.0 * x);
  }
  if (law.damper_table) {
    products.check("the damper table's slope times stretch and rate",
                   exponent_of(law.damper_table->slope(0.0)) + x + xdot);
  }
  if (law.actuator) products.check("the actuator's work", exponent_of(sizes_of(*law.actuator, until).value) + x);
}

void check_body(const Body& body, const MachineSizes& sizes, ProductChecks& products) {
  const double mass = exponent_of(body.modal ? body.modal->G(0, 0) : body.mass);
  products.check_both("mass times the square of the machine's length", mass + 2.0 * sizes.length);
  products.check("mass times the square of the machine's speed", mass + 2.0 * sizes.speed);
  products.check("the weight's moment", mass + sizes.gravity + sizes.length);
  products.check("inertia times the square of the machine's turning rate",
                 exponent_of(largest_entry(body.inertia_L)) + 2.0 * sizes.turn_rate);
  if (!body.modal) return;
  const double a = exponent_of(largest_entry(body.a_start));
  const double adot = exponent_of(largest_entry(body.adot_start));
  products.check("modal stiffness times the square of the modal coordinates",
                 exponent_of(largest_entry(body.modal->stiffness)) + 2.0 * a);
  products.check("modal damping times the square of the modal speeds",
                 exponent_of(largest_entry(body.modal->damping)) + 2.0 * adot);
}

void check_joint(const Joint& joint, const MachineSizes& sizes, ProductChecks& products) {
  for (const JointSpring& spring : joint.springs) {
    const auto word = static_cast<std::size_t>(spring.word);
    const bool slides = joints::is_length(joint.type->permits[word], spring.component);
    const VecX& q = joint.start[word].q;
    const double angle = spring.component < q.size() ? std::max(0.0, exponent_of(q(spring.component))) : 0.0;
    check_law(spring.law, slides ? sizes.length : angle, slides ? sizes.speed : sizes.turn_rate, sizes.until(),
              products);
  }
  for (const Driver& driver : joint.drivers) {
    if (stays_usable(driver.law, sizes.until())) continue;
    products.check("a driver's law, or one of its derivatives,", std::numeric_limits<double>::max_exponent10);
  }
}

/// The products of a force element in which its quantities stand.
struct QuantityProducts {
  const MachineSizes& sizes;
  ProductChecks& products;
  double factor = 0.0;  // exponent of the law that multiplies forces and torques

  void operator()(const elements::Word& /*word*/) const {}
  void operator()(const elements::RoadBelow<const std::shared_ptr<const Road>>& /*road*/) const {}
  void operator()(const elements::FactorOverTime<const TimeFunction>& /*seen before*/) const {}
  void operator()(const elements::LawOverCoordinate<const ForceLaw>& spring) const {
    check_law(spring.value, spring.over_length ? sizes.length : 0.5, spring.over_length ? sizes.speed : sizes.turn_rate,
              sizes.until(), products);
  }
  void operator()(const elements::Vector<const Vec3>& vector) const {
    const bool is_force = vector.of.length == 0;
    products.check(is_force ? "the force's moment" : "the torque",
                   exponent_of(vector.value.norm()) + factor + (is_force ? sizes.length : 0.0));
  }
  void operator()(const elements::Wrench6<const Vec6>& wrench) const {
    products.check(std::string(wrench.name) + " times the machine's length",
                   exponent_of(largest_entry(wrench.value)) + std::max(0.5, sizes.length));
  }
  void operator()(const elements::WrenchMatrix<const Mat6>& matrix) const {
    const double length = std::max(0.5, sizes.length);
    const double motion = matrix.per_rate ? std::max(sizes.speed, sizes.turn_rate) : length;
    products.check(std::string(matrix.name) + (matrix.per_rate ? " times the machine's length and speed"
                                                               : " times the square of the machine's length"),
                   exponent_of(largest_entry(matrix.value)) + motion + length);
  }
  /// A force law of one number, whose product with lengths and speeds of the machine is an energy.
  void operator()(const elements::Scalar<const double>& number) const {
    const double value = exponent_of(number.value);
    if (number.of.force == 0) return;
    if (number.of.length == 0) {
      products.check(words_of(number.name) + " times slip and length", value + slip + sizes.length);
    } else if (number.of.time == 0) {
      products.check(words_of(number.name) + " times the square of the machine's length", value + 2.0 * sizes.length);
    } else {
      products.check(words_of(number.name) + " times the machine's length and speed",
                     value + sizes.length + sizes.speed);
    }
  }
  double slip = 0.0;  // exponent of the machine's speed over that of slip

  static std::string words_of(std::string_view key) {
    std::string words(key);
    std::replace(words.begin(), words.end(), '_', ' ');
    return words;
  }
};

void check_element(const ForceElement& element, const MachineSizes& sizes, ProductChecks& products) {
  QuantityProducts check{sizes, products};
  each_quantity(element, Overloaded{elements::IgnoreQuantity{},
                                    [&](const elements::FactorOverTime<const TimeFunction>& law) {
                                      check.factor = exponent_of(sizes_of(law.value, sizes.until()).value);
                                    },
                                    [&](const elements::Scalar<const double>& number) {
                                      if (is_speed(number.of)) check.slip = sizes.speed - exponent_of(number.value);
                                    }});
  each_quantity(element, check);
}

}  // namespace

std::string complaint_about_size(double value) {
  return fmt::format("must be zero or of a size from {} to {}, found {}", kSmallestSize, kLargestSize, value);
}

double rounding_of(const std::string& text) {
  const std::size_t exponent = std::min(text.find_first_of("eE"), text.size());
  const std::size_t point = text.find('.');
  const double decimals = point < exponent ? static_cast<double>(exponent - point - 1) : 0.0;
  const double power = exponent < text.size() ? std::strtod(text.c_str() + exponent + 1, nullptr) : 0.0;
  return 0.5 * std::pow(10.0, power - decimals);
}

bool stays_usable(const TimeFunction& law, double until) {
  const LawSizes sizes = sizes_of(law, until);
  // A derivative may be as small as it likes: it is never divided by.
  return sizes.value <= kLargestSize && sizes.rate <= kLargestSize &&
         size_of_second_derivative(law, until) <= kLargestSize;
}

std::vector<Diagnostic> complaints_about_products(const Model& model) {
  const MachineSizes sizes(model);
  std::vector<Diagnostic> complaints;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const Body& body = model.bodies[i];
    ProductChecks products(fmt::format("body '{}'", body.name), body.where, complaints);
    check_body(body, sizes, products);
  }
  for (const Joint& joint : model.joints) {
    ProductChecks products(fmt::format("joint '{}'", joint.name), joint.where, complaints);
    check_joint(joint, sizes, products);
  }
  for (const ForceElement& element : model.elements) {
    ProductChecks products(fmt::format("force element '{}'", element.name), element.where, complaints);
    check_element(element, sizes, products);
  }
  return complaints;
}

}  // namespace concord
