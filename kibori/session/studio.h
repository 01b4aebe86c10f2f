// SPDX-License-Identifier: MIT
// A document that a hand carves in by a pointer or a force device, and all that a view of it shows. No
// network, no picture: see apps/studio for those.
//
//   owner's thread:  aim, press, lift, undo ─► PointerDevice, commands ─► servo thread (LiveCarving)
//                    follow()  ◄─ snapshots, ticks                              │ log
//                    place()   ◄─ where the document stands ◄── scribe's threads ◄┘
//
// All of it belongs to one thread; servo and scribe have theirs. One that is opened to be looked at has
// neither: it goes to any step, and changes nothing.
#pragma once

#include <array>
#include <atomic>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <kibori/base/handover.h>
#include <kibori/devices/pointer_device.h>
#include <kibori/motion/scene.h>
#include <kibori/session/experiment.h>
#include <kibori/session/live_carving.h>
#include <kibori/session/scribe.h>
#include <kibori/surface/surface.h>

namespace kibori {

class Studio {
 public:
  // Where the document stands.
  struct Place {
    StepId step = 0;
    size_t steps = 0;
    bool undo = false, redo = false;  // whether there is somewhere to go
    uint64_t hash = 0;                // of the model at `step`
    std::string trouble;              // see Scribe::trouble()
  };
  struct PastStep {
    StepId id = 0, parent = 0;  // the stock has no parent: 0
    double removed_mm3 = 0;     // negative: added
  };
  using Versions = std::map<std::string, StepId>;
  struct Options {
    bool read_only = false;  // it is only looked at
    std::string device;      // a name of devices/registry.h that holds the tool; empty: a pointer does
  };
  // Of the force device that holds the tool.
  struct Held {
    std::string name;
    double force_n = 0;                        // the most it can give
    double stiffness_n_mm = 0, most_n_mm = 0;  // to begin with; that it can bear, at this reach
    double scale = 1;                          // so far the tool goes for a mm of the hand
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
  double rate_hz() const { return rate_hz_; }
  bool read_only() const { return viewed_ != nullptr; }
  // What runs by itself; null: a hand carves.
  Experiment* experiment() { return experiment_.get(); }
  // The pointer's hand: tip and axis (from the tip up; any length but zero) of the tool [mm].
  void aim(const Vec3& tip_mm, const Vec3& axis, bool at_once = false);
  // Puts the tool there, clear of material, and lets it cut or fill from then on.
  void press(const Vec3& tip_mm, const Vec3& axis, Mode mode);
  void lift();
  // How far the tool is turned about its own axis from then on [rad].
  void turn(double roll_rad);
  bool pressed() const { return pressed_; }
  // The force device, as of the last ticks(); null: a pointer holds the tool.
  const Held* held() const { return held_ ? &*held_ : nullptr; }
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
  Status choose_stiffness(double n_mm);
  Status choose_material(size_t material);  // of what is added
  Status choose_model(HandModel model);
  Status choose_symmetry(const std::array<bool, 3>& planes);  // through the lattice's middle

  // To be called every few ms: the surface follows the model. The chunks that changed.
  const std::vector<Index3>& follow();
  const LiveSurface& surface() const { return *surface_; }
  // Ticks since the last call, oldest first.
  const std::vector<LiveTick>& ticks();
  const Place& place();
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
  // Volume [mm^3], as of the last follow() and ticks().
  double volume_mm3() const { return volume_mm3_; }
  double removed_mm3() const { return removed_mm3_; }
  // A sentence for the person; empty where there is none. Taken away by asking.
  std::string notice();

 private:
  Studio() = default;
  static Result<std::unique_ptr<Studio>> start(std::unique_ptr<Document> document,
                                               std::unique_ptr<TriDexel> model, const Scene& scene,
                                               const Options& options);
  static Result<std::unique_ptr<Studio>> look(std::unique_ptr<Document> document);
  Status post(std::function<void(LiveCarving&)> command);
  void look_at(const Result<StepId>& step);
  void tell(const Status& how);
  void tell_stiffness();
  void count_volume();
  void with_document(std::function<void(Document&)> f);

  std::string name_;
  Lattice lattice_;
  double rate_hz_ = 1000;
  std::vector<Material> materials_;
  PointerDevice* pointer_ = nullptr;  // live_'s, if one holds the tool
  Mat3 aimed_ = Mat3::Identity();     // as it last was to stand, but for
  double roll_rad_ = 0;
  std::optional<Held> held_;
  double damping_ns_mm_ = 0;  // of the device
  Tool tool_;
  Symmetry symmetry_;
  // Instead of live_ and scribe_, where it runs by itself or is only looked at.
  std::unique_ptr<Experiment> experiment_;
  std::unique_ptr<Document> viewed_;
  std::unique_ptr<TriDexel> shown_;
  bool anew_ = false;  // follow() has not seen snapshot_ yet
  std::string notice_;
  std::unique_ptr<LiveCarving> live_;
  std::unique_ptr<LiveSurface> surface_;
  // From the scribe's thread.
  std::atomic<bool> asked_{false};  // for what follows
  std::mutex told_mutex_;
  struct Told {
    bool fresh = false;
    Place place;
    std::vector<PastStep> steps;  // that were not told of yet
    Versions versions;
    std::string notice;
  } told_;
  StepId last_told_ = 0;            // of that thread
  std::unique_ptr<Scribe> scribe_;  // gone before what it writes of
  Snapshot snapshot_;
  std::vector<Index3> changed_;
  std::vector<LiveTick> ticks_;
  Place place_;
  std::vector<PastStep> steps_;
  Versions versions_;
  bool pressed_ = false, lifting_ = false, cutting_ = false, volume_known_ = false;
  double volume_mm3_ = 0, removed_mm3_ = 0;
};

}  // namespace kibori
