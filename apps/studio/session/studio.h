// SPDX-License-Identifier: MIT
// A document that a hand carves in by a pointer or a force device, and all that a view of it shows. No
// network, no picture: see apps/studio for those.
//
//   owner's thread:  aim, press, lift, undo ─► PointerDevice, commands ─► servo thread (LiveCarving)
//                    follow()  ◄─ snapshots, ticks                              │ log
//                    place()   ◄─ where the document stands ◄── the document writer's threads ◄┘
//
// All of it belongs to one thread; servo and document writer have theirs. One that is opened to be looked at
// has neither: it goes to any step, and changes nothing.
#pragma once

#include <array>
#include <atomic>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <kibori/base/handover.h>
#include <kibori/batch/scene.h>
#include <kibori/devices/pointer_device.h>
#include "apps/studio/session/experiment.h"
#include <kibori/live/document_writer.h>
#include <kibori/live/live_carving.h>
#include <kibori/surface/surface.h>

namespace kibori {

// A blow of the mallet [N mm]: 3 J, a tap of a carver's mallet of half a kilogram at 3.5 m/s.
inline constexpr double kMalletNmm = 3000;

class Studio {
 public:
  // Where the document stands.
  struct HistoryState {
    StepId step = 0;
    size_t steps = 0;
    bool undo = false, redo = false;  // whether there is somewhere to go
    uint64_t hash = 0;                // of the model at `step`
    std::string trouble;              // see DocumentWriter::trouble()
  };
  struct PastStep {
    StepId id = 0, parent = 0;  // the stock has no parent: 0
    double removed_mm3 = 0;     // negative: added
    int64_t made_s = 0;         // when it was begun [s since 1970]; 0: not known
    std::optional<Tool> tool;   // the stock has none
    Mode mode = Mode::cut;
    bool pictured = false;  // whether thumbnail() had a picture of it when the step was first told of
    std::string label;
  };
  using Versions = std::map<std::string, StepId>;
  struct Options {
    bool read_only = false;  // it is only looked at
    std::string device;      // a name of devices/registry.h that holds the tool; empty: a pointer does
  };
  // The hand that pushes the tool.
  struct Hand {
    double strength_n = kHandStrengthN;  // S: it pushes with this at most
    double stiffness_n_mm = 0;           // between hand and tool; 0: what suits a pointer, or the device
    bool powered = true;  // a motor turns the tool, and the hand bears kPoweredShare of the cut
  };
  // Of the force device that holds the tool.
  struct HapticDeviceState {
    std::string name;
    double force_n = 0;                        // the most it can give
    double stiffness_n_mm = 0, most_n_mm = 0;  // at the hand: what is rendered, and what it can bear
    double scale = 1;                          // so far the tool goes for a mm of the hand
    double share = 1;                          // s: of the wood's force, what is felt: force_n / strength
    SafetyStage::State safety = SafetyStage::State::off;
    Trip trip = Trip::none;
    double given_n = 0;
  };

  // A document that is there, with the tool and materials of its last stroke. Errors: those of the document
  // and the device.
  static Result<std::unique_ptr<Studio>> open(const std::filesystem::path& document, const Options& options);
  // A new document of the stock, tool and materials of `scene`. Errors: it is there already; those of the
  // stock and the device; it is only to be looked at.
  static Result<std::unique_ptr<Studio>> create(const std::filesystem::path& document, const Scene& scene,
                                                const Options& options);
  // A scene that is carved to be looked at, without a document. Errors: those of the stock.
  static Result<std::unique_ptr<Studio>> watch(const Scene& scene, double pace);
  // What could not be saved is then put elsewhere: see close().
  ~Studio() { static_cast<void>(close()); }
  // Ends the stroke and the session, and saves. A sentence on where the document is, if not where it belongs.
  std::string close();

  const Lattice& lattice() const { return lattice_; }
  const std::string& document_name() const { return name_; }
  const std::vector<Material>& materials() const { return materials_; }
  uint8_t stock_material() const { return stock_material_; }  // what the stock is of: a number of materials()
  double rate_hz() const { return rate_hz_; }
  bool read_only() const { return viewed_ != nullptr; }
  // What runs by itself; null: a hand carves.
  Experiment* experiment() { return experiment_.get(); }
  // The pointer's hand: tip and axis (from the tip up; any length but zero) of the tool [mm], and when that
  // was so [s], by whatever clock. While it is pressed, the tool follows these places one after another.
  void aim(const Vec3& tip_mm, const Vec3& axis, double time_s);
  // Begins a stroke at this place: the tool backs out from there along its axis until it is clear of
  // material, comes in again, and cuts, fills or feels from then on.
  void press(const Vec3& tip_mm, const Vec3& axis, Mode mode, double time_s);
  // Ends the stroke, once the tool has been everywhere that it was aimed to.
  void lift();
  // A blow of the mallet on a tool that cuts: it is driven on along the aim by kMalletNmm of work.
  void strike();
  // How far the tool is turned about its own axis from then on [rad].
  void turn(double roll_rad);
  // Whether a stroke is being made, or has not come to its end yet.
  bool pressed() const { return pressed_ || !later_.empty(); }
  // Whether the tool, which is pressed, stands in material and can't back out: it cuts nothing there.
  bool blocked() const { return pressed() && inside_; }
  // The force device, as of the last ticks(); null: a pointer holds the tool.
  const HapticDeviceState* held() const { return held_ ? &*held_ : nullptr; }
  // What its tool does from now on.
  void work(Mode mode);
  void arm(bool armed);
  // The tool is there from now on, wherever the hand is [mm].
  void bring(const Vec3& tip_mm);
  // Errors: a scale that can't be, or at which the device could not bear the spring; nothing has changed.
  Status choose_reach(double scale);

  // The stroke that is being made is as if it had not been.
  void cancel();
  void undo();
  void redo();
  void go(StepId step);
  // Errors: what the tool, or the spring, can't be; nothing has changed.
  Status choose_tool(const Tool& tool);
  // Errors: a strength that is not 20 to 1000 N, a stiffness that is not 0 or 0.01 to 10000 N/mm, or that the
  // device can't bear.
  Status choose_hand(const Hand& hand);
  const Hand& hand() const { return hand_; }
  Status choose_material(size_t material);  // of what is added
  Status choose_model(HandModel model);
  Status choose_symmetry(const std::array<bool, 3>& planes);  // through the lattice's middle

  // To be called every few ms: the surface follows the model. The chunks that changed.
  const std::vector<Index3>& follow();
  const LiveSurface& surface() const { return *surface_; }
  // Ticks since the last call, oldest first.
  const std::vector<LiveTick>& ticks();
  const HistoryState& place();
  // What was done, in the order of its numbers, as of the last place().
  const std::vector<PastStep>& steps() const { return steps_; }
  const Versions& versions() const { return versions_; }
  // Of the step that the document stands at; what can't be is told by notice().
  void name_version(const std::string& name);
  // Small pictures of steps (PNG). `use` is called on another thread, or at once, with nothing where there is
  // none.
  void keep_thumbnail(StepId step, Bytes png);
  void thumbnail(StepId step, std::function<void(Bytes)> use);
  // All of the document, packed, into a new file; `done` is called on another thread, or at once.
  void save_copy(const std::filesystem::path& path, std::function<void(Status)> done);
  // The model, as of the last follow().
  const Snapshot& snapshot() const { return snapshot_; }
  // Volume [mm^3], as of the last follow() and ticks(); and how much less that is than the stock's.
  double volume_mm3() const { return volume_mm3_; }
  double removed_mm3() const { return stock_mm3_ - volume_mm3_; }
  // A sentence for the person; empty where there is none. Taken away by asking.
  std::string notice();

 private:
  Studio() = default;
  static Result<std::unique_ptr<Studio>> start(std::unique_ptr<Document> document,
                                               std::unique_ptr<TriDexel> model, const Scene& scene,
                                               const Options& options);
  static Result<std::unique_ptr<Studio>> look(std::unique_ptr<Document> document,
                                              std::unique_ptr<TriDexel> at_head);
  // At the last step that is whole, of a document whose head is not; `why`: what is damaged.
  static Result<std::unique_ptr<Studio>> look_at_whole(const std::filesystem::path& file,
                                                       std::unique_ptr<Document> damaged,
                                                       const std::string& why);
  // In order, and not before all strokes that were lifted have come to their end.
  Status post(std::function<void(LiveCarving&)> command);
  void then(std::function<void()> what);
  void go_on();
  std::optional<Pose> pose_of(const Vec3& tip_mm, const Vec3& axis, bool anew);
  Status give_hand(const Hand& hand, double reach);
  void look_at(const Result<StepId>& step);
  void tell(const Status& how);
  void count_volume();
  void with_document(std::function<void(Document&)> f);
  PastStep past_step(const Document& document, const Step& step);

  std::string name_;
  Lattice lattice_;
  double rate_hz_ = 1000;
  std::vector<Material> materials_;
  uint8_t stock_material_ = 0;
  PointerDevice* pointer_ = nullptr;  // live_'s, if one holds the tool
  uint32_t stroke_ = 0;               // the pointer's newest
  // What waits for the end of a stroke: until it is finished, or for a command's room.
  struct Later {
    uint32_t stroke = 0;          // to wait for, or
    std::function<bool()> run{};  // false: there was no room for it, and it is run again
  };
  std::deque<Later> later_;
  Hand hand_;
  double default_n_mm_ = 0;        // the stiffness that suits the device
  Mat3 aimed_ = Mat3::Identity();  // as it last was to stand, but for
  double roll_rad_ = 0;
  std::optional<HapticDeviceState> held_;
  Tool tool_;
  Symmetry symmetry_;
  // Instead of live_ and writer_, where it runs by itself or is only looked at.
  std::unique_ptr<Experiment> experiment_;
  std::unique_ptr<Document> viewed_;
  std::unique_ptr<TriDexel> shown_;
  bool anew_ = false;  // follow() has not seen snapshot_ yet
  std::string notice_;
  std::unique_ptr<LiveCarving> live_;
  std::unique_ptr<LiveSurface> surface_;
  // From the document writer's thread.
  std::atomic<bool> asked_{false};  // for what follows
  std::mutex told_mutex_;
  struct Told {
    bool fresh = false;
    HistoryState place;
    std::vector<PastStep> steps;  // that were not told of yet
    Versions versions;
    std::string notice;
  } told_;
  StepId last_told_ = 0;  // of that thread
  // Tool and mode by Step::setting, of the thread that has the document: many strokes share them.
  std::map<int64_t, std::pair<std::optional<Tool>, Mode>> settings_seen_;
  std::unique_ptr<DocumentWriter> writer_;  // gone before what it writes of
  Snapshot snapshot_;
  std::vector<Index3> changed_;
  std::vector<LiveTick> ticks_;
  HistoryState place_;
  std::vector<PastStep> steps_;
  Versions versions_;
  bool pressed_ = false, inside_ = false, cutting_ = false, volume_known_ = false;
  double volume_mm3_ = 0, stock_mm3_ = 0;
};

}  // namespace kibori
