// SPDX-License-Identifier: MIT
// A document that a hand carves in by a pointer, and all that a view of it shows. No network, no picture: see
// apps/studio for those.
//
//   owner's thread:  aim, press, lift, undo ─► PointerDevice, commands ─► servo thread (LiveCarving)
//                    follow()  ◄─ snapshots, ticks                              │ log
//                    place()   ◄─ where the document stands ◄── scribe's threads ◄┘
//
// All of it belongs to one thread; servo and scribe have theirs.
#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <kibori/base/handover.h>
#include <kibori/devices/pointer_device.h>
#include <kibori/motion/scene.h>
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

  // Opens a document, or makes a new one of the stock, materials and tool of `scene`. Errors: those of both.
  static Result<std::unique_ptr<Studio>> open(const std::filesystem::path& document, const Scene& scene);
  // What could not be saved is then put elsewhere: see close().
  ~Studio() { static_cast<void>(close()); }
  // Ends the stroke and the session, and saves. A sentence on where the document is, if not where it belongs.
  std::string close();

  const Lattice& lattice() const { return lattice_; }
  const std::string& document_name() const { return name_; }
  double rate_hz() const { return rate_hz_; }

  // The hand: tip and axis (from the tip up; any length but zero) of the tool [mm].
  void aim(const Vec3& tip_mm, const Vec3& axis, bool at_once = false);
  // Puts the tool there, clear of material, and lets it cut or fill from then on.
  void press(const Vec3& tip_mm, const Vec3& axis, Mode mode);
  void lift();
  bool pressed() const { return pressed_; }
  // The stroke that is being made is as if it had not been.
  void cancel();
  void undo();
  void redo();
  // Errors: what the tool, or the spring, can't be; nothing has changed.
  Status choose_tool(const Tool& tool);
  Status choose_stiffness(double n_mm);

  // To be called every few ms: the surface follows the model. The chunks that changed.
  const std::vector<Index3>& follow();
  const LiveSurface& surface() const { return *surface_; }
  // Ticks since the last call, oldest first.
  const std::vector<LiveTick>& ticks();
  const Place& place();
  // Volume [mm^3], as of the last follow() and ticks().
  double volume_mm3() const { return volume_mm3_; }
  double removed_mm3() const { return removed_mm3_; }
  // A sentence for the person; empty where there is none. Taken away by asking.
  std::string notice() { return scribe_->notice(); }

 private:
  Studio() = default;

  std::string name_;
  Lattice lattice_;
  double rate_hz_ = 1000;
  std::vector<Material> materials_;
  PointerDevice* pointer_ = nullptr;  // live_'s
  std::unique_ptr<LiveCarving> live_;
  std::unique_ptr<LiveSurface> surface_;
  LatestValue<Place> places_;       // from the scribe
  std::atomic<bool> asked_{false};  // for a place
  std::unique_ptr<Scribe> scribe_;  // gone before what it writes of
  Snapshot snapshot_;
  std::vector<Index3> changed_;
  std::vector<LiveTick> ticks_;
  Place place_;
  bool pressed_ = false, volume_known_ = false;
  double volume_mm3_ = 0, removed_mm3_ = 0;
};

}  // namespace kibori
