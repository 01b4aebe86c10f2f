// SPDX-License-Identifier: MIT
// The bodies while the user works on one of them, the active one. Tools change the model of the
// active body. The others keep their last state.
#pragma once

#include <utility>

#include <kibori/body/bodies.h>

namespace kibori {

class Workbench {
 public:
  // `model` is the model of body `active`. All other models must share its memory (TriDexel).
  Workbench(TriDexel& model, BodyList bodies, BodyId active)
      : model_(model), bodies_(std::move(bodies)), active_(active) {}
  explicit Workbench(TriDexel& model) : Workbench(model, BodyList::of(model), 1) {}

  TriDexel& model() { return model_; }
  BodyId active() const { return active_; }
  // All bodies in their current state.
  const BodyList& bodies();
  // Errors: no such body.
  Status activate(BodyId id);
  // Errors: see apply(). If the active body is removed, the first body becomes active.
  Result<BodyChange> act(const BodyAction& action, int threads = 1);
  // The material that strokes on the active body must not cut at this moment; null if there is
  // none. Errors: see no_go_of.
  Result<const NoGo*> no_go();
  // Handles the pieces that a stroke cut off. `before` is the model before the stroke.
  CrumbResult end_stroke(const Snapshot& before, Crumbs rule);
  // Replaces all bodies.
  void set(BodyList bodies, BodyId active);

 private:
  void load();

  TriDexel& model_;
  BodyList bodies_;
  BodyId active_;
  // Cached result of no_go(). Empty after another body became active, or an action changed bodies.
  std::optional<std::shared_ptr<const NoGo>> no_go_;
};

}  // namespace kibori
