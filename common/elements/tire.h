#pragma once

#include <array>
#include <memory>

#include "common/elements/facts.h"
#include "common/laws/road.h"

namespace concord {

/// A tire on a wheel, in the manner of DADS' basic model. `wheel` is the wheel's centre c; y of its frame A' is the
/// spin axis a. It acts on the wheel's body only: ground is the road.
///
/// The road below the centre, at x = c_x, is replaced by its tangent plane: normal n = (-h', 0, 1) / sqrt(1 + h'^2),
/// distance of the centre D = (c_z - h) n_z, deflection delta = radius - D, deltadot = -dD/dt along the motion.
/// Directions in the plane: forward t_x = a x n / |a x n|, sideways t_y = n x t_x. With v the velocity of c and omega'
/// that of A':
///   V_x = v . t_x and V_y = v . t_y: how the centre travels;  s_x = (v - D omega' x n) . t_x: how the contact slips.
/// At standstill the slip laws are dampers and hold nothing: under a force F along the road a locked wheel creeps at
/// about F speed_scale / slip_stiffness, across it at F speed_scale / cornering_stiffness.
/// The force N n + F_x t_x + F_y t_y acts at the contact, c - D n; what the results hold is this wrench at c. N, F_x
/// and F_y are the scalar laws below (S36), (S37), (S39).
struct Tire {
  Attachment wheel;
  std::shared_ptr<const Road> road;
  double radius = 0.0;               // m
  double stiffness = 0.0;            // N/m
  double damping = 0.0;              // N s/m
  double slip_stiffness = 0.0;       // N: -F_x over the slip s_x / V
  double cornering_stiffness = 0.0;  // N: -F_y over the slip angle's tangent V_y / V
  double friction = 0.0;             // limit of |F_x, F_y| / N
  double speed_scale = 0.1;          // m/s: V = sqrt(V_x^2 + speed_scale^2), regular at standstill

  static constexpr std::string_view kKey = "tire";
  static constexpr elements::EndAxes kEndAxes = elements::EndAxes::about_y;  // its spin
  static constexpr bool kSidesAlike = false;
  template <class Self>
  static auto ends_of(Self& self) {
    return elements::Ends{&self.wheel, 1};
  }
  template <class Self, class Visit>
  static void each_quantity(Self& self, const Visit& visit) {
    visit(elements::RoadBelow{"road", self.road});
    visit(elements::Scalar{"radius", self.radius, elements::kLength});
    visit(elements::Scalar{"stiffness", self.stiffness, elements::kForcePerLength});
    visit(elements::Scalar{"damping", self.damping, elements::kForcePerSpeed});
    visit(elements::Scalar{"slip_stiffness", self.slip_stiffness, elements::kForce});
    visit(elements::Scalar{"cornering_stiffness", self.cornering_stiffness, elements::kForce});
    visit(elements::Scalar{"friction", self.friction, elements::kNoUnit});
    visit(elements::Scalar{"speed_scale", self.speed_scale, elements::kSpeed});
  }
};

/// In which way the laws of a tire hold; between two regimes a derivative jumps, or the force where a damped tire
/// lands. An integrator keeps the regime during a step, as if the laws of the regime went on for ever, and ends the
/// step where the regime ends.
struct TireRegime {
  int stretch = 0;       // of the road
  bool touches = false;  // delta > 0
  bool pushes = false;   // touches, and stiffness delta + damping deltadot > 0: a tire does not pull
  bool slides = false;   // pushes, and the linear slip forces exceed friction N
  /// The direction of the slip forces where sliding began, F_x and F_y of unit size; zero: none.
  double along_x = 0.0;
  double along_y = 0.0;
  bool operator==(const TireRegime& other) const {
    return stretch == other.stretch && touches == other.touches && pushes == other.pushes && slides == other.slides &&
           along_x == other.along_x && along_y == other.along_y;
  }
};

/// What the laws are said of.
struct TireContact {
  double x = 0.0;         // of the centre
  double delta = 0.0;     // m
  double deltadot = 0.0;  // m/s
  double V_x = 0.0;
  double V_y = 0.0;
  double s_x = 0.0;
};

struct TireForces {
  double N = 0.0;
  double F_x = 0.0;
  double F_y = 0.0;
};

/// N = stiffness delta + damping deltadot if the tire pushes, else zero; F_x = -slip_stiffness s_x / V and
/// F_y = -cornering_stiffness V_y / V, both scaled down by one factor to sqrt(F_x^2 + F_y^2) = friction N if it slides.
/// Where the slip has turned by more than a right angle since sliding began, as in a step that passes its end, its part
/// along that first direction is reflected: friction keeps its sense and jumps nowhere. If it turned about, the
/// midpoints of a long step could lie on one side, its results on the other, and all extrapolations would say the same:
/// a step that is wrong without an error.
TireForces evaluate(const Tire& tire, const TireRegime& regime, const TireContact& contact);  // (S38)

/// The regime that a contact is in by itself.
TireRegime regime_at(const Tire& tire, const TireContact& contact);

/// How far the contact is inside a regime, by the ends that a regime may have: both edges of the stretch, touching,
/// pushing, sliding, and sliding within a right angle of where it began. Positive inside, through zero where the regime
/// ends; in units of its own (a length over the radius, a force over stiffness radius, of sliding times V /
/// speed_scale); infinite for an end that it does not have.
inline constexpr int kTireEvents = 6;
std::array<double, kTireEvents> event_functions_of(const Tire& tire, const TireRegime& regime,
                                                   const TireContact& contact);
/// The smallest of them.
double event_function_of(const Tire& tire, const TireRegime& regime, const TireContact& contact);

}  // namespace concord
