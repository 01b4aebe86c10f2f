// SPDX-License-Identifier: MIT
// The bodies while one of them, the active one, is worked on: its model is under the tool, the
// others are as they were left.
#pragma once

#include <utility>

#include <kibori/body/bodies.h>

namespace kibori {

class Workbench {
 public:
  // `model` is that of body `active`; all models are of it, or of models beside it (TriDexel).
  Workbench(TriDexel& model, Bodies bodies, BodyId active)
      : model_(model), bodies_(std::move(bodies)), active_(active) {}
  explicit Workbench(TriDexel& model) : Workbench(model, Bodies::of(model), 1) {}

  TriDexel& model() { return model_; }
  BodyId active() const { return active_; }
  // All as they are now.
  const Bodies& bodies();
  // Errors: no such body.
  Status activate(BodyId id);
  // Errors as of apply(). Where the active body goes, the first one becomes active.
  Result<BodyChange> act(const BodyAction& action, int threads = 1);
  // What strokes on the active body may not cut, as of now; null: nothing. Errors as of no_go_of.
  Result<const NoGo*> no_go();
  // What a stroke severed, which began at `before`.
  CrumbResult end_stroke(const Snapshot& before, Crumbs rule);
  // Others from now on.
  void set(Bodies bodies, BodyId active);

 private:
  void load();

  TriDexel& model_;
  Bodies bodies_;
  BodyId active_;
  // Of the active body, until others are there, or stand otherwise.
  std::optional<std::shared_ptr<const NoGo>> no_go_;
};

}  // namespace kibori
