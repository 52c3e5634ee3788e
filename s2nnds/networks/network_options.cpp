// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/networks/network_options.h"

#include "s2nnds/core/check.h"
#include "s2nnds/networks/network_weights.h"

namespace s2nnds {

void MlpOptions::visit(FieldVisitor& v) {
  v.field("hidden", hidden, between(1, 4096));
  v.field("activation", activation, activation_names());
  v.field("output_activation", output_activation, activation_names());
  v.field("bias", bias);
  v.field("first_layer_gain", first_layer_gain, above(0.0));
  v.field("first_layer_bias", first_layer_bias, at_least(0.0));
}

void VectorFieldOptions::visit(FieldVisitor& v) {
  network.visit(v);
  v.field("zero_at_origin", zero_at_origin);
  v.field("form", form, {"auto", "plain", "projected"});
  if (form != "plain") v.field("decay", decay, above(0.0));
}

void LyapunovOptions::visit(FieldVisitor& v) {
  network.visit(v);
  v.field("form", form, {"auto", "squared_norm", "scalar", "diffeomorphism"});
  if (form == "auto" || form == "squared_norm") {
    v.field("features", features, between(1, 4096));
    v.field("quadratic", quadratic, above(0.0));
  }
  if (form == "auto" || form == "diffeomorphism") v.field("lipschitz", lipschitz, inside(0.0, 1.0));
}

void BarrierOptions::visit(FieldVisitor& v) {
  network.visit(v);
  v.field("wall_slope", wall_slope, at_least(0.0));
}

void NetworkOptions::choose_forms(bool projected) {
  if (f.form == "auto") f.form = projected ? "projected" : "plain";
  if (V.form == "auto") V.form = f.form == "projected" ? "diffeomorphism" : "squared_norm";
}

void NetworkOptions::visit(FieldVisitor& v) {
  v.group("f", f);
  v.group("V", V);
  v.group("B", B);
}

NetworkOptions paper_networks() {
  NetworkOptions options;
  options.f = {.network = {.hidden = {64, 64, 64, 64}, .output_activation = "tanh", .bias = false},
               .zero_at_origin = false,
               .form = "plain"};
  options.V = {.network = {.hidden = {128, 128, 128}, .activation = "elu", .bias = false}, .form = "scalar"};
  options.B = {.network = {.hidden = {128, 128, 128}, .activation = "elu"}, .wall_slope = 0.0};
  return options;
}

}  // namespace s2nnds
