// SPDX-License-Identifier: MIT
// A document that a hand carves in by a pointer or a force device.
//
//   owner's thread:  aim, press, lift, undo ─► PointerDevice, commands ─► servo (LiveCarving)
//                    follow()  ◄─ snapshots, ticks                                   │ log
//                    history() ◄─ where the document stands ◄── the document writer ◄┘
//
// The servo and the document writer have threads of their own.
#pragma once

#include <array>
#include <atomic>
#include <deque>
#include <mutex>
#include <optional>

#include <kibori/devices/pointer_device.h>
#include <kibori/motion/stroke_guide.h>
#include <kibori/live/document_writer.h>
#include "apps/studio/session/session.h"
#include "apps/studio/session/session_hand.h"

namespace kibori {

// A blow of the mallet [N mm]: 3 J, a tap of a carver's mallet of half a kilogram at 3.5 m/s.
inline constexpr double kMalletNmm = 3000;

class LiveSession final : public Session {
 public:
  // The hand that pushes the tool.
  struct Hand {
    double strength_n = kHandStrengthN;  // S: it pushes with this at most
    // Between hand and tool; 0: what suits a pointer, or the device.
    double stiffness_n_mm = 0;
    double share = kPoweredShare;  // of the cut's force, what the hand bears
  };
  // With the tool and materials of `scene`. `notice`: what the person is told first. Errors: those
  // of the device.
  static Result<std::unique_ptr<Session>> make(std::unique_ptr<Document> document,
                                               std::unique_ptr<TriDexel> model, const Scene& scene,
                                               const SessionOptions& options,
                                               const std::string& notice);
  // What could not be saved is then put elsewhere: see close().
  ~LiveSession() override { static_cast<void>(close_document()); }

  LiveSession* live() override { return this; }

  // Where SessionOptions::stepped: one tick of the servo.
  void tick();

  // The pointer's hand: tip and axis (from the tip up; any length but zero) of the tool [mm], and
  // when that was so [s], by whatever clock. While it is pressed, the tool follows these places one
  // after another.
  void aim(const Vec3& tip_mm, const Vec3& axis, double time_s);
  // Begins a stroke at this place: the tool backs out from there along its axis until it is clear
  // of material, comes in again, and cuts, fills or feels from then on.
  void press(const Vec3& tip_mm, const Vec3& axis, Mode mode, double time_s);
  // Ends the stroke, once the tool has been everywhere that it was aimed to.
  void lift();
  // A blow of the mallet on a tool that cuts: it is driven on along the aim by kMalletNmm of work.
  void strike();
  // How far the tool is turned about its own axis from then on [rad].
  void turn(double roll_rad);
  // Whether a stroke is being made, or has not come to its end yet.
  bool pressed() const { return first_.pressed() || second_.pressed() || !later_.empty(); }
  // Whether the tool, which is pressed, stands in material and can't back out: it cuts nothing
  // there.
  bool blocked() const { return (first_.pressed() || !later_.empty()) && inside_; }
  // The second hand's tool, and what it does while its pointer is pressed, or all the time where a
  // device holds it: cut, deposit, touch; off: there is no second hand. Errors: what the tool can't
  // be, another mode, or how it can't lead; nothing has changed.
  struct Lead {
    bool leads = false;
    double entry_mm = 0, lift_mm = 0;  // as of StrokeGuideSettings
  };
  Status choose_second(const Tool& tool, Mode mode, const Lead& lead);
  const Tool* second_tool() const override { return second_tool_ ? &*second_tool_ : nullptr; }
  // As aim(), press() and lift(), of its pointer. What both hands do until both are lifted is one
  // stroke.
  void aim_second(const Vec3& tip_mm, const Vec3& axis, double time_s);
  void press_second(const Vec3& tip_mm, const Vec3& axis, double time_s);
  void lift_second();

  // The force device, as of the last ticks(); null: a pointer holds the tool.
  const HapticDeviceState* held() const { return first_.held ? &*first_.held : nullptr; }
  // Of the second hand.
  const HapticDeviceState* second_held() const { return second_.held ? &*second_.held : nullptr; }
  // What its tool does from now on.
  void work(Mode mode);
  void arm(bool armed);
  // The tool is there from now on, wherever the hand is [mm].
  void bring(const Vec3& tip_mm);
  // Errors: a scale that can't be, or at which the device could not bear the spring; nothing has
  // changed.
  Status choose_reach(double scale);

  // Errors: what the tool, or the spring, can't be; nothing has changed.
  Status choose_tool(const Tool& tool);
  // Errors: a strength that is not 20 to 1000 N, a stiffness that is not 0 or 0.01 to 10000 N/mm,
  // or that the device can't bear.
  Status choose_hand(const Hand& hand);
  const Hand& hand() const { return hand_; }
  Status choose_material(size_t material);  // of what is added
  // Of modes that reshape, from the next stroke on. Until one is chosen it is as wide as the tool
  // asks, and as strong as it may be.
  Status choose_brush(const Brush& brush);
  Status choose_model(ForceModel model);
  // Planes and axis through the lattice's middle; see Symmetry.
  Status choose_symmetry(const std::array<bool, 3>& planes, int fold, Axis axis);
  // Of the pointers' strokes from the next one on; whether the second's tool leads choose_second
  // says. Errors: what a guide can't be; nothing has changed.
  Status choose_guide(const StrokeGuideSettings& guide);
  // Of strokes from the next one on: what becomes of what they sever.
  Status choose_crumbs(Crumbs crumbs);
  Crumbs crumbs() const { return crumbs_; }

  // What is done with bodies, as a step; what can't be is told by notice().
  void act(const BodyAction& action);
  // The same in place of what was done in a step, on the way to `head`: Document::revise.
  void revise(StepId step, StepId head, const BodyAction& action);
  // What an action would come to is shown until the document has another state, or until
  // end_preview(). Errors: it can't be done; then what was shown before is. Forces [N]: of a
  // spline, of the hands that moved its control points since the preview before,
  // as of soft clay.
  Result<std::vector<Vec3>> preview(const BodyAction& action);
  void end_preview();
  // The last spline on the way to the head, as JSON: step, parent, head, action; empty: there is
  // none. `use` is called on another thread, or at once.
  void last_spline(std::function<void(std::string)> use);
  // The body that strokes go to.
  void choose_body(BodyId body);

  void cancel() override;
  void undo() override;
  void redo() override;
  void go(StepId step) override;
  void name_version(const std::string& name) override;
  void keep_thumbnail(StepId step, Bytes png) override;
  void thumbnail(StepId step, std::function<void(Bytes)> use) override;
  void save_copy(const std::filesystem::path& path, std::function<void(Status)> done) override;
  std::string notice() override;
  std::string close() override { return close_document(); }

 private:
  StrokeGuideSettings second_guide(const Lead& lead) const;
  LiveSession() = default;
  LiveSettings take_scene(const Scene& scene);
  Result<std::unique_ptr<Device>> open_hand(const std::string& name, const Box& material_mm,
                                            ServoHandSettings& settings, SessionHand& hand);
  std::string close_document();
  // In order, and not before all strokes that were lifted have come to their end.
  Status post(std::function<void(ServoContext&)> command);
  void then(std::function<void()> what);
  void go_on();
  Status give_hand(const Hand& hand, double reach);
  Status fits_hand(const Tool& tool) const;
  Status can_work(Mode mode) const;
  void lift_both() {
    lift();
    lift_second();
  }

  bool latest(Shown& shown) override;
  bool next_tick(LiveTick& tick) override;
  void update_history() override;
  bool busy() const override { return pressed() || cutting_; }

  std::array<SessionHand, 2> hands_;
  SessionHand &first_ = hands_[0], &second_ = hands_[1];
  // What waits for the end of a stroke: until it is finished, or for a command's room.
  struct Later {
    std::function<bool()> run;  // false: it is not time yet, or there was no room; it is run again
  };
  std::deque<Later> later_;
  Hand hand_;
  double default_n_mm_ = 0;          // the stiffness that suits the device
  std::optional<Tool> second_tool_;  // nothing: there is no second hand
  Mode second_mode_ = Mode::off;
  StrokeGuideSettings guide_;
  Lead second_lead_;
  Tool tool_;
  Symmetry symmetry_;
  Crumbs crumbs_ = Crumbs::sort;
  // All bodies, as the document has them; the model under the tool, and whose it is.
  Bodies listed_;
  Snapshot carved_;
  BodyId carved_body_ = 1;
  bool shown_before_ = true;         // what latest() gave is still as it is
  std::optional<Bodies> previewed_;  // is shown in place of them
  std::optional<SplineShape> last_previewed_;
  std::optional<Brush> brush_;
  Brush brush_of(Mode mode) const;
  bool inside_ = false;
  bool stepped_ = false;  // see SessionOptions
  std::unique_ptr<LiveCarving> live_;
  // From the document writer's thread.
  std::atomic<bool> asked_{false};  // for what follows
  std::mutex told_mutex_;
  struct Told {
    bool fresh = false;
    HistoryState history;
    std::optional<Bodies> bodies;  // where there are others, or they are others
    std::vector<PastStep> steps;   // that were not told of yet
    Versions versions;
    std::string notice;
  } told_;
  StepId last_told_ = 0;  // of that thread, as are past_ and told_bodies_of_
  StepId told_bodies_of_ = 0;
  PastSteps past_;
  std::unique_ptr<DocumentWriter> writer_;  // gone before what it writes of
};

}  // namespace kibori
