#include "common/laws/road.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace concord {
namespace {

const Road kFlat{"flat", FlatRoad{-0.3}};
const Road kBump{"bump", HalfSineBump{.start = 2.0, .length = 0.8, .height = 0.05}};

Road table_road() {
  return {"table", RoadTable{SplineTable({-1.0, 0.0, 0.5, 1.5, 2.0}, {0.1, 0.3, 0.2, 0.25, -0.1}), -1.0, 2.0}};
}

/// Derivative by central differences of fourth order.
template <class Function>
double road_difference(const Function& f, double x) {
  constexpr double h = 1e-3;
  return (8.0 * (f(x + h) - f(x - h)) - (f(x + 2.0 * h) - f(x - 2.0 * h))) / (12.0 * h);
}

TEST(Road, DerivativesOfEveryStretchAreThoseByDifferences) {
  const Road table = table_road();
  for (const Road* road : {&kFlat, &kBump, &table}) {
    for (int stretch = 0; stretch <= stretch_at(*road, 1e9); ++stretch) {
      // Beyond the edges too: there the stretch's own function goes on. No knot of the table is near.
      for (const double x : {-1.7, 0.22, 0.9, 1.93, 2.31, 2.77, 4.0}) {
        const RoadHeight found = evaluate(*road, stretch, x);
        EXPECT_NEAR(found.slope, road_difference([&](double z) { return evaluate(*road, stretch, z).h; }, x), 1e-9)
            << road->name << " " << stretch << " " << x;
        EXPECT_NEAR(found.curvature, road_difference([&](double z) { return evaluate(*road, stretch, z).slope; }, x),
                    1e-8)
            << road->name << " " << stretch << " " << x;
      }
    }
  }
}

TEST(Road, IsContinuousAtItsEdgesWhichBelongToTheStretchBehind) {
  constexpr double kEver = std::numeric_limits<double>::infinity();
  const Road table = table_road();
  EXPECT_EQ(edges_of(kFlat, 0), (std::array{-kEver, kEver}));
  EXPECT_EQ(edges_of(kBump, 1), (std::array{2.0, 2.8}));
  EXPECT_EQ(edges_of(table, 0), (std::array{-kEver, -1.0}));
  EXPECT_EQ(edges_of(table, 2), (std::array{0.0, 0.5}));
  EXPECT_EQ(edges_of(table, 5), (std::array{2.0, kEver}));
  for (const Road* road : {&kBump, &table}) {
    const int last = stretch_at(*road, 1e9);
    for (int k = 0; k < last; ++k) {
      const double edge = edges_of(*road, k)[1];
      EXPECT_EQ(edges_of(*road, k + 1)[0], edge) << road->name;
      EXPECT_EQ(stretch_at(*road, edge), k + 1) << road->name;
      EXPECT_EQ(stretch_at(*road, std::nextafter(edge, -9.0)), k) << road->name;
      const RoadHeight before = evaluate(*road, k, edge);
      const RoadHeight behind = evaluate(*road, k + 1, edge);
      EXPECT_NEAR(before.h, behind.h, 1e-16) << road->name;
      const bool is_end = k == 0 || k == last - 1;
      EXPECT_EQ(std::abs(before.slope - behind.slope) > 0.1, is_end) << road->name << ": a kink at " << edge;
      if (!is_end) EXPECT_NEAR(before.curvature, behind.curvature, 1e-14) << road->name << " " << edge;
    }
  }
  EXPECT_EQ(stretch_at(kFlat, 1e9), 0);
}

TEST(Road, HasACubicOfItsOwnBetweenTwoPointsOfATable) {
  const Road table = table_road();
  const auto third = [&](int stretch) {
    return evaluate(table, stretch, 0.4).curvature - evaluate(table, stretch, 0.3).curvature;
  };
  EXPECT_NEAR(third(1), third(2), 1e-13) << "as the condition at the table's begin asks";
  EXPECT_GT(std::abs(third(2) - third(3)), 0.1);
}

TEST(Road, HasTheHeightsOfItsProfile) {
  EXPECT_EQ(evaluate(kFlat, 0, 7.0).h, -0.3);
  EXPECT_EQ(evaluate(kFlat, 0, 7.0).slope, 0.0);
  EXPECT_NEAR(evaluate(kBump, 1, 2.4).h, 0.05, 1e-17);
  EXPECT_NEAR(evaluate(kBump, 1, 2.2).h, 0.05 * std::numbers::sqrt2 / 2.0, 1e-16);
  EXPECT_NEAR(evaluate(kBump, 1, 2.0).slope, 0.05 * std::numbers::pi / 0.8, 1e-16);
  EXPECT_EQ(evaluate(kBump, 0, 2.4).h, 0.0);
  EXPECT_EQ(evaluate(kBump, 2, 2.4).h, 0.0);
  const Road table = table_road();
  EXPECT_NEAR(evaluate(table, 3, 0.5).h, 0.2, 1e-16);
  EXPECT_NEAR(evaluate(table, 0, -8.0).h, 0.1, 1e-16);
  EXPECT_NEAR(evaluate(table, 5, 8.0).h, -0.1, 1e-16);
}

}  // namespace
}  // namespace concord
