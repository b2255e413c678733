#include <catch2/catch.hpp>

#include "compare/verdict/reference.h"
#include "judged_machines.h"

/// A tire on a test rig through slip, slip angle and sliding, against a table from outside. Published tables are of
/// measured tires, or of laws that bend before they slide (brush, Magic Formula); this tire's law is straight until it
/// slides, so its table is a closed form, by a program of its own: data/references/tire_test_rig.py.
namespace concord::verification {
namespace {

const std::filesystem::path kData = CONCORD_DATA;

/// Verdict on the rig where both solvers may solve another machine, with the reference's rows.
compare::Verdict against_the_table(const Model& model, const Model& solved) {
  const compare::Reference reference = compare::read_reference(kData / "references" / "tire_test_rig.csv", model);
  const auto cartesian_solver = cartesian::make_solver(solved);
  const auto relative_solver = relative::make_solver(solved);
  compare::VerifyOptions options;
  options.states = 40;
  compare::Verdict verdict = compare::verify(model, *cartesian_solver, *relative_solver, options);
  compare::judge_reference(model, reference, verdict);
  return verdict;
}

Tire& tire_of(Model& model) { return std::get<Tire>(model.elements.at(0).what); }

}  // namespace

TEST_CASE("A tire that slips, is steered and slides does what its table says", "[tire][reference]") {
  const Model model = read_model(kData / "models" / "tire_test_rig.toml");
  const compare::Verdict verdict = against_the_table(model, model);
  INFO(compare::format_verdict(model, verdict, false));
  CHECK(verdict.outcome == compare::Outcome::agree);
  REQUIRE(verdict.references.size() == 6);
  for (const compare::ReferenceRow& row : verdict.references) {
    CHECK(row.word == compare::ReferenceWord::equal);
  }
}

TEST_CASE("A fault in any number of a tire, in both solvers alike, misses its table", "[tire][reference]") {
  const Model model = read_model(kData / "models" / "tire_test_rig.toml");
  for (double Tire::*number : {&Tire::radius, &Tire::stiffness, &Tire::slip_stiffness, &Tire::cornering_stiffness,
                               &Tire::friction, &Tire::speed_scale}) {
    Model slipped = model;
    tire_of(slipped).*number *= 1.0 + 1e-5;
    const compare::Verdict verdict = against_the_table(model, slipped);
    CHECK(verdict.outcome == compare::Outcome::differ);
    CHECK(std::any_of(verdict.references.begin(), verdict.references.end(),
                      [](const compare::ReferenceRow& row) { return compare::is_off(row); }));
  }
}

}  // namespace concord::verification
