#include "s2nnds/verification/certificate.h"

#include <array>
#include <utility>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

constexpr std::array<std::pair<Guarantee, std::string_view>, 5> kGuaranteeNames = {{
    {Guarantee::none, "none"},
    {Guarantee::sampled, "sampled"},
    {Guarantee::conformal, "conformal"},
    {Guarantee::proved, "proved"},
    {Guarantee::invariant, "invariant"},
}};

const Range kCount = at_least(0);

}  // namespace

std::string_view to_string(Guarantee guarantee) {
  for (const auto& [value, name] : kGuaranteeNames) {
    if (value == guarantee) return name;
  }
  fail("guarantee: found the value {}, expected 0 to 4", static_cast<int>(guarantee));
}

Guarantee guarantee_from(std::string_view name) {
  for (const auto& [value, known] : kGuaranteeNames) {
    if (known == name) return value;
  }
  fail("guarantee: found \"{}\", expected none, sampled, conformal, proved or invariant", name);
}

void ConditionVerdict::visit(FieldVisitor& v) {
  v.field("condition", condition);
  v.field("method", method, {"sampled", "conformal", "proof"});
  v.field("verdict", verdict, {"passed", "failed", "proved", "refuted", "undecided"});
  v.field("samples", samples, kCount);
  v.field("violations", violations, kCount);
  v.field("seed", seed, any_number());
  v.field("worst", worst, any_number());
  v.field("epsilon", epsilon, between(0, 1));
  v.field("beta", beta, between(0, 1));
  v.field("attempt", attempt, kCount);
  v.field("order", order, kCount);
  v.field("quantile", quantile, any_number());
  v.field("tightest_epsilon", tightest_epsilon, between(0, 1));
  v.field("boxes", boxes, kCount);
  v.field("open_boxes", open_boxes, kCount);
  v.field("open_volume", open_volume, at_least(0));
  v.field("witness", witness, any_number());
  v.field("seconds", seconds, at_least(0));
}

void Certificate::visit(FieldVisitor& v) {
  v.field("guarantee", guarantee, {"none", "sampled", "conformal", "proved", "invariant"});
  v.field("method", method);
  v.field("weight_hash", weight_hash);
  v.field("attempts", attempts, kCount);
  v.field("level_band", level_band, at_least(0));
  v.field("disturbance_margin", disturbance_margin, at_least(0));
  v.field("convergence_radius", convergence_radius, at_least(0));
  v.field("float32_error", float32_error, any_number());
  v.field("statement", statement);
  v.list("conditions", conditions);
}

}  // namespace s2nnds
