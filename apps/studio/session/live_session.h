// SPDX-License-Identifier: MIT
// A document that a user carves with a pointer or a force device.
//
//   owner's thread:  aim, press, lift, undo ─► PointerDevice, commands ─► servo (LiveCarving)
//                    follow()  ◄─ snapshots, ticks                                   │ log
//                    history() ◄─ the document's state ◄───── the document writer ◄──┘
//
// The servo and the document writer have their own threads. All functions are for the owner's
// thread.
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

// The work of a mallet's blow [N mm]: 3 J, as of a mallet of 0.5 kg at 3.5 m/s.
inline constexpr double kMalletNmm = 3000;

class LiveSession final : public Session {
 public:
  // The hand that pushes the tool.
  struct Hand {
    double strength_n = kHandStrengthN;  // S: the maximum pull of the hand
    // Stiffness of the spring between hand and tool. 0: the default of the pointer or the device.
    double stiffness_n_mm = 0;
    double share = kPoweredShare;  // share of the cutting force that the hand supports
  };
  // Makes a session with the tool and the materials of `scene`. notice() returns `notice` first.
  // Errors: those of the device.
  static Result<std::unique_ptr<Session>> make(std::unique_ptr<Document> document,
                                               std::unique_ptr<TriDexel> model, const Scene& scene,
                                               const SessionOptions& options,
                                               const std::string& notice);
  // Closes the document. Work that cannot be saved in its file is saved elsewhere: see close().
  ~LiveSession() override { static_cast<void>(close_document()); }

  LiveSession* live() override { return this; }

  // Runs one servo tick. Only for sessions with SessionOptions::stepped.
  void tick();

  // Moves the pointer: its tip [mm], its axis (from the tip up, any length but 0), and the time [s]
  // by any clock. While the pointer is pressed, the tool follows these poses in order. `pressure`
  // is that of a pen, 0 to 1, for brushes that follow it.
  void aim(const Vec3& tip_mm, const Vec3& axis, double time_s, double pressure = 1);
  // Begins a stroke at this pose. If the tool would be inside material there, it starts farther
  // back along its axis, where it is clear. From there, it moves to the pose and works in its mode.
  void press(const Vec3& tip_mm, const Vec3& axis, Mode mode, double time_s, double pressure = 1);
  // Ends the stroke after the tool has followed all poses.
  void lift();
  // Strikes the tool with the mallet. The blow drives a cutting tool along the aim with the work
  // kMalletNmm.
  void strike();
  // Sets the tool's rotation about its own axis [rad].
  void turn(double roll_rad);
  // Returns true during a stroke, and after lift() while the tool still follows the path.
  bool pressed() const { return first_.pressed() || second_.pressed() || !later_.empty(); }
  // Returns true if the pressed tool is inside material and cannot back out. Then it cuts nothing.
  bool blocked() const { return (first_.pressed() || !later_.empty()) && inside_; }
  // Returns the part of a brush's stroke that is not in the model yet, as time of the hand's motion
  // [s]. ticks() updates this value.
  double pending_s() const { return pending_s_; }
  // Sets the second hand's tool and its mode: cut, deposit, touch or off. The tool works while the
  // second pointer is pressed. If a device holds it, the tool always works. Errors: the tool, the
  // mode or the lead is invalid; then nothing changes.
  struct Lead {
    bool leads = false;
    double entry_mm = 0, lift_mm = 0;  // as in StrokeGuideSettings
  };
  Status choose_second(const Tool& tool, Mode mode, const Lead& lead);
  const Tool* second_tool() const override { return second_tool_ ? &*second_tool_ : nullptr; }
  // As aim(), press() and lift(), for the second pointer. All work of the two hands until both are
  // lifted is one stroke.
  void aim_second(const Vec3& tip_mm, const Vec3& axis, double time_s);
  void press_second(const Vec3& tip_mm, const Vec3& axis, double time_s);
  void lift_second();

  // Returns the state of the force device at the last ticks(). Null: a pointer holds the tool.
  const HapticDeviceState* held() const { return first_.held ? &*first_.held : nullptr; }
  // Returns the state of the second hand's force device.
  const HapticDeviceState* second_held() const { return second_.held ? &*second_.held : nullptr; }
  // Sets the mode of the tool that the device holds.
  void work(Mode mode);
  void arm(bool armed);
  // Moves the tool to this position [mm]. The hand stays in place.
  void bring(const Vec3& tip_mm);
  // Sets the motion of the tool per mm of the hand. Errors: no device holds the tool; the scale is
  // not 0.1 to 20. Then nothing changes.
  Status choose_reach(double scale);

  // Changes the tool. Errors: the tool is invalid, or too large for a hand. Then nothing changes.
  Status choose_tool(const Tool& tool);
  // Errors: the strength is not 20 to 1000 N; the stiffness is neither 0 nor 0.01 to 10000 N/mm;
  // the device cannot render the stiffness.
  Status choose_hand(const Hand& hand);
  const Hand& hand() const { return hand_; }
  Status choose_material(size_t material);  // the material that deposits add
  // Sets the brush of reshaping modes, from the next stroke on. Without this call, the radius
  // depends on the tool, and the strength is 1. If the brush has the texture `picture`, the picture
  // of choose_texture() is used. If there is none, the brush gets no texture. Errors: the brush is
  // invalid, or too large for the pitch.
  Status choose_brush(Brush brush);
  void choose_texture(std::shared_ptr<const AlphaPicture> picture) {
    texture_ = std::move(picture);
  }
  Status choose_model(ForceModel model);
  // Planes and axis go through the middle of the lattice. See Symmetry.
  Status choose_symmetry(const std::array<bool, 3>& planes, int fold, Axis axis);
  // Sets the guide for strokes of the pointers, from the next stroke on. For the second tool,
  // choose_second() sets the lead. Errors: the guide is invalid; then nothing changes.
  Status choose_guide(const StrokeGuideSettings& guide);
  // Sets the rule for severed pieces, from the next stroke on.
  Status choose_crumbs(Crumbs crumbs);
  Crumbs crumbs() const { return crumbs_; }

  // Applies an action on bodies as a step. notice() returns its error.
  void act(const BodyAction& action);
  // Replaces the action of a step on the path to `head`. See Document::revise.
  void revise(StepId step, StepId head, const BodyAction& action);
  // Shows the result of an action, until the document changes or until end_preview(). For a spline,
  // returns a force [N] for each control point: the force of soft clay on a finger that moved this
  // point to its place from the place in the previous preview. Errors: the action is impossible;
  // then the previous preview stays.
  Result<std::vector<Vec3>> preview(const BodyAction& action);
  void end_preview();
  // Finds the last spline on the path to the head. `use` gets it as JSON (step, parent, head,
  // action), or an empty text if there is none. `use` is called on another thread, or at once.
  void last_spline(std::function<void(std::string)> use);
  // Makes a body the active one.
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
  // Runs `command` after all lifted strokes have ended. Commands keep their order.
  Status post(std::function<void(ServoContext&)> command);
  void then(std::function<void()> what);
  void resume();
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
  // Work that waits for the end of a stroke, or for room in the command queue.
  struct Later {
    std::function<bool()> run;  // returns false if it is not ready; then it is called again
  };
  std::deque<Later> later_;
  Hand hand_;
  double default_n_mm_ = 0;          // default stiffness of the device
  std::optional<Tool> second_tool_;  // nullopt: there is no second hand
  Mode second_mode_ = Mode::off;
  StrokeGuideSettings guide_;
  Lead second_lead_;
  Tool tool_;
  Symmetry symmetry_;
  Crumbs crumbs_ = Crumbs::sort;
  BodyList listed_;                    // all bodies of the document
  Snapshot carved_;                    // the model under the tool
  BodyId carved_body_ = 1;             // the body of carved_
  bool shown_before_ = true;           // true if the last result of latest() is still valid
  std::optional<BodyList> previewed_;  // shown instead of listed_
  std::optional<SplineShape> last_previewed_;
  std::optional<Brush> brush_;
  std::shared_ptr<const AlphaPicture> texture_;  // null: none
  Brush brush_of(Mode mode) const;
  bool inside_ = false;
  double pending_s_ = 0;
  bool stepped_ = false;  // see SessionOptions
  std::unique_ptr<LiveCarving> live_;
  // Members that the document writer's thread uses, too.
  std::atomic<bool> refresh_requested_{false};  // true if update_history() has a pending request
  std::mutex changes_mutex_;
  struct Changes {
    bool fresh = false;
    HistoryState history;
    std::optional<BodyList> bodies;  // set if they have changed
    std::vector<PastStep> steps;     // steps that are not delivered yet
    Versions versions;
    std::string notice;
  } changes_;
  StepId last_sent_ = 0;  // used on the document writer's thread, like the next two members
  StepId sent_bodies_of_ = 0;
  PastSteps past_;
  std::unique_ptr<DocumentWriter> writer_;  // destroyed before the data that it uses
};

}  // namespace kibori
