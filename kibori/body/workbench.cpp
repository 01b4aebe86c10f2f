// SPDX-License-Identifier: MIT
#include <kibori/body/workbench.h>

namespace kibori {

const BodyList& Workbench::bodies() {
  if (Body* const body = bodies_.find(active_)) {
    body->model = model_.snapshot();
    body->material_bounds = model_.material_bounds();
  }
  return bodies_;
}

void Workbench::load() {
  if (!bodies_.find(active_)) active_ = bodies_.all.front().id;
  no_go_.reset();
  const Body& body = *bodies_.find(active_);
  model_.restore(body.model);
  model_.include_material(body.material_bounds);
}

Status Workbench::activate(BodyId id) {
  if (!bodies_.find(id)) return Error{"there is no body " + std::to_string(id)};
  if (id == active_) return Ok{};
  bodies();
  active_ = id;
  load();
  return Ok{};
}

Result<BodyChange> Workbench::act(const BodyAction& action, int threads) {
  bodies();
  Result<BodyChange> done = apply(bodies_, action, threads);
  if (done) load();
  return done;
}

Result<const NoGo*> Workbench::no_go() {
  if (!no_go_) {
    Result<std::shared_ptr<const NoGo>> made = no_go_of(bodies_, active_);
    if (!made) return Error{made.error()};
    no_go_ = std::move(made).value();
  }
  return no_go_->get();
}

CrumbResult Workbench::end_stroke(const Snapshot& before, Crumbs rule) {
  const Result<const NoGo*> kept = no_go();
  CrumbResult result = take_crumbs(model_, before, rule, kept ? kept.value() : nullptr);
  if (!result.portions.empty()) add_bodies(bodies_, bodies_.find(active_)->pose, result.portions);
  return result;
}

void Workbench::set(BodyList bodies, BodyId active) {
  bodies_ = std::move(bodies);
  active_ = active;
  load();
}

}  // namespace kibori
