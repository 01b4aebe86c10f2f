// SPDX-License-Identifier: MIT
// Repeats an action with other data, and the steps that followed after it.
#include <kibori/document/document.h>

#include <algorithm>

#include <kibori/body/workbench.h>

namespace kibori {

Status Document::revise(StepId step, const BodyAction& action, int threads) {
  if (!writes_) return wrong("is open read-only");
  if (open_step_ != 0) return wrong("a stroke is in progress; finish or cancel it first");
  const StepId was = head_;
  const Result<std::vector<StepId>> path = path_to(was);
  if (!path) return Error{path.error()};
  const std::vector<StepId>& path_steps = path.value();
  const auto at = std::find(path_steps.begin(), path_steps.end(), step);
  if (at == path_steps.end())
    return wrong("step " + std::to_string(step) + " is not on the path to the current step");
  if (!steps_.at(step).action)
    return wrong("step " + std::to_string(step) +
                 " is not an action on bodies; only such a step can be revised");
  const auto restore = [&](StepId there) -> Status {
    const Result<Checkout> to = checkout(there);
    return to ? commit_checkout(to.value()) : Status(Error{to.error()});
  };
  if (Status before = restore(steps_.at(step).parent); !before) return before;
  const Result<BodyChange> done = act(action, threads);
  Status all = done ? Status(Ok{}) : Status(Error{done.error()});
  for (auto next = std::next(at); all && next != path_steps.end(); ++next)
    if (const Status again = do_again(*next, threads); !again)
      all = Error{"step " + std::to_string(*next) +
                  " cannot be repeated after the change: " + again.error()};
  if (all) return all;
  Status back = restore(was);
  return back ? all : back;
}

Status Document::do_again(StepId step, int threads) {
  if (!steps_.at(step).action) {
    const Result<StrokeSettings> how = settings(step);
    return how ? carve_again(step, how.value()) : Status(Error{how.error()});
  }
  const Result<BodyAction> what = action(step);
  if (!what) return Error{what.error()};
  const Result<BodyChange> done = act(what.value(), threads);
  return done ? Status(Ok{}) : Status(Error{done.error()});
}

Status Document::carve_again(StepId step, const StrokeSettings& settings) {
  const Result<Pose> from = start(step);
  if (!from) return Error{from.error()};
  const BodyList* const state = state_of(head_);
  if (!state) return wrong("none of its models is loaded");
  const Body& now = *state->find(active_);
  TriDexel model(now.model, now.material_bounds);
  Workbench bench(model);
  bench.set(*state, active_);
  if (Status there = bench.activate(settings.body); !there) return there;
  const Result<const NoGo*> no_go = bench.no_go();
  if (!no_go) return Error{no_go.error()};
  if (Status begun = begin(settings, from.value(), steps_.at(step).label); !begun) return begun;
  const Snapshot before = bench.model().snapshot();
  Status carved = replay_ticks(step, settings, bench.model(), no_go.value(), std::nullopt,
                               [&](const ReplayedTick& tick) { add(*tick.recorded); });
  if (carved) {
    double removed = before.volume_mm3() - bench.model().volume_mm3();
    CrumbResult crumbs;
    if (settings.crumbs != Crumbs::stay) crumbs = bench.end_stroke(before, settings.crumbs);
    carved = finish(bench.model(), removed + crumbs.fallen_mm3, crumbs.portions);
  }
  if (carved || open_step_ == 0) return carved;
  Status off = cancel();
  return off ? carved : off;
}

}  // namespace kibori
