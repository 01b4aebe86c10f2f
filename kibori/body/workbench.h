// SPDX-License-Identifier: MIT
// The bodies of a document while the user works on one of them, the active body. Tools change the
// model of the active body. The other bodies keep their last state.
#pragma once

#include <utility>

#include <kibori/body/bodies.h>

namespace kibori {

class Workbench {
 public:
  // `model` must be the model of body `active`. The models of all other bodies must share its
  // memory (TriDexel).
  Workbench(TriDexel& model, BodyList bodies, BodyId active)
      : model_(model), bodies_(std::move(bodies)), active_(active) {}
  explicit Workbench(TriDexel& model) : Workbench(model, BodyList::of(model), 1) {}

  TriDexel& model() { return model_; }
  BodyId active() const { return active_; }
  // All bodies in their current state.
  const BodyList& bodies();
  // Makes a body active. Error: there is no such body.
  Status activate(BodyId id);
  // Applies an action. Errors: see apply(). If the action removes the active body, the first body
  // becomes active.
  Result<BodyChange> act(const BodyAction& action, int threads = 1);
  // Returns the region that strokes on the active body must not cut; null if there is none. It is
  // valid until another body becomes active or an action changes bodies. Errors: see no_go_of.
  Result<const NoGo*> no_go();
  // Handles the pieces that a stroke severed (take_crumbs). `before` is the model before the
  // stroke.
  CrumbResult end_stroke(const Snapshot& before, Crumbs rule);
  // Replaces all bodies, and makes `active` the active one.
  void set(BodyList bodies, BodyId active);

 private:
  void load();

  TriDexel& model_;
  BodyList bodies_;
  BodyId active_;
  // Cached result of no_go(). It has no value after another body became active, or after an action.
  std::optional<std::shared_ptr<const NoGo>> no_go_;
};

}  // namespace kibori
