// SPDX-License-Identifier: MIT
// A session has the data that the studio's pages show. There are four kinds: a document that a user
// carves (LiveSession), a read-only document (HistoryViewer), a scene that is carved by itself
// (ExperimentSession), and a milling job (PlaybackSession). Sessions do not use the network. One
// thread owns a session.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <kibori/base/bytes.h>
#include <kibori/base/result.h>
#include <kibori/scene/scene.h>
#include <kibori/document/document.h>
#include <kibori/live/live_carving.h>
#include <kibori/surface/surface.h>

namespace kibori {

class ExperimentSession;
class LiveSession;
class PlaybackSession;

// The state of a document's history.
struct HistoryState {
  StepId step = 0;
  size_t steps = 0;
  bool undo = false, redo = false;  // true if there is a step to go to
  uint64_t hash = 0;                // hash of the models at `step`
  std::string write_error;          // see DocumentWriter::write_error()
};

struct PastStep {
  StepId id = 0, parent = 0;  // 0 for the stock, which has no parent
  double removed_mm3 = 0;     // negative: added
  int64_t made_s = 0;         // start of the step [s since 1970]; 0: unknown
  std::optional<Tool> tool;   // nullopt for the stock
  Mode mode = Mode::cut;
  bool pictured = false;  // true if there was a picture when the step was first listed
  std::string label;
};

struct SessionOptions {
  bool read_only = false;  // documents are opened read-only
  // The device of devices/registry.h that holds the tool. Empty: a pointer.
  std::string device;
  // LiveSession::tick() moves the tool instead of a thread, so that the time of a test is exact.
  // Only a pointer and the simulated hand can be stepped, because a real device needs a tick every
  // ms.
  bool stepped = false;
  // The device that holds the second tool. Empty: a pointer. A device is possible only if `device`
  // is not empty.
  std::string second = {};
};

class Session {
 public:
  using Versions = std::map<std::string, StepId>;

  virtual ~Session() = default;
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  // Return this session as one of its kinds, or null. live(): a hand carves. experiment(): a scene
  // is carved. playback(): a milling job runs.
  virtual LiveSession* live() { return nullptr; }
  virtual ExperimentSession* experiment() { return nullptr; }
  virtual PlaybackSession* playback() { return nullptr; }

  // Returns the second hand's tool, or null.
  virtual const Tool* second_tool() const { return nullptr; }

  const Lattice& lattice() const { return lattice_; }
  const std::string& name() const { return name_; }  // name of the document or the scene
  const std::vector<Material>& materials() const { return materials_; }
  uint8_t stock_material() const {
    return stock_material_;
  }  // the stock's material: an index of materials()
  double rate_hz() const { return rate_hz_; }

  // Updates the surfaces to the newest models. Call it every few ms. Returns the chunks that
  // changed.
  struct ChunkPlace {
    BodyId body = 1;
    Index3 at = Index3::Zero();
  };
  const std::vector<ChunkPlace>& follow();
  // Return all bodies with their models at the last follow(), and the active body.
  const BodyList& bodies() const { return shown_.bodies; }
  BodyId active() const { return shown_.active; }
  const Body& active_body() const { return *shown_.bodies.find(shown_.active); }
  const Snapshot& snapshot() const { return active_body().model; }
  // Returns a revision. It increases when a body, its volume, or the active body changes.
  uint64_t bodies_revision() const { return bodies_revision_; }
  // Returns the surface of a body, or null if there is no such body.
  const LiveSurface* surface(BodyId body) const;
  // Returns the volume of a body [mm^3]. The volume of the active body is updated only while no
  // stroke runs.
  double volume_mm3(BodyId body) const;
  // Returns the ticks since the last call, oldest first.
  const std::vector<LiveTick>& ticks();
  // Return the total volume [mm^3] at the last follow() and ticks(), and the stock's volume minus
  // this volume.
  double volume_mm3() const { return volume_mm3_; }
  double removed_mm3() const { return stock_mm3_ - volume_mm3_; }

  const HistoryState& history();
  // Returns the steps in the order of their numbers, at the last history().
  const std::vector<PastStep>& steps() const { return steps_; }
  const Versions& versions() const { return versions_; }
  virtual void undo() {}
  virtual void redo() {}
  virtual void go(StepId) {}
  // Discards the current stroke. Stops an experiment.
  virtual void cancel() {}
  // Names the current step. notice() returns the error.
  virtual void name_version(const std::string& name);
  // A thumbnail is a small picture of a step (PNG). `use` is called on another thread, or at once.
  // It gets an empty picture if there is none.
  virtual void keep_thumbnail(StepId, Bytes) {}
  virtual void thumbnail(StepId step, std::function<void(Bytes)> use) = 0;
  // Writes the whole document into a new file, without unused space. `done` is called on another
  // thread, or at once.
  virtual void save_copy(const std::filesystem::path& path, std::function<void(Status)> done) = 0;
  // Returns a sentence for the user, or an empty text. Each sentence is returned once.
  virtual std::string notice() { return std::exchange(notice_, {}); }
  // Ends the stroke and saves the document. If its file could not be written, returns a sentence
  // with the place where the document is now. Otherwise, returns an empty text.
  virtual std::string close() { return {}; }

 protected:
  Session() = default;
  struct Shown {
    BodyList bodies;
    BodyId active = 1;
  };
  // Sets the first state. The volume of the stock is that of `first` plus `removed_mm3`.
  void begin(Shown first, double removed_mm3);
  void notify(const Status& how) {
    if (!how) notice_ = how.error();
  }

  // Writes the newest state to `shown` and returns true, if it has changed since the last call. The
  // state has at least one body, and `active` is one of its bodies.
  virtual bool latest(Shown& shown) = 0;
  virtual bool next_tick(LiveTick&) { return false; }
  virtual void update_history() = 0;
  // Returns true while the model changes. Then its volume is not computed, because this takes time.
  virtual bool busy() const { return false; }

  std::string name_;
  Lattice lattice_;
  double rate_hz_ = 1000;
  std::vector<Material> materials_;
  uint8_t stock_material_ = 0;
  std::vector<LiveTick> ticks_;
  HistoryState history_;
  std::vector<PastStep> steps_;
  Versions versions_;
  std::string notice_;
  bool cutting_ = false;  // result of the last ticks()
  bool volume_known_ = false;

 private:
  void count_volume();
  struct Seen {
    LiveSurface surface;
    double volume_mm3 = 0;
  };
  Shown shown_;
  std::map<BodyId, Seen> seen_;
  uint64_t bodies_revision_ = 1;
  std::vector<ChunkPlace> changed_;
  double volume_mm3_ = 0, stock_mm3_ = 0;
};

// Opens a document with the tool and the materials of its last stroke. If its head is damaged,
// opens the last undamaged step read-only. Errors: those of the document and of the device.
Result<std::unique_ptr<Session>> open_session(const std::filesystem::path& document,
                                              const SessionOptions& options);
// Creates a document with the stock, the tool and the materials of `scene`. Errors: the file
// exists; those of the stock and of the device; options.read_only is true.
Result<std::unique_ptr<Session>> create_session(const std::filesystem::path& document,
                                                const Scene& scene, const SessionOptions& options);

// Converts the steps of a document for pages. Only for the thread that owns the document.
class PastSteps {
 public:
  PastStep of(const Document& document, const Step& step);

 private:
  // Tool and mode for each Step::setting. Many strokes have the same setting.
  std::map<int64_t, std::pair<std::optional<Tool>, Mode>> settings_;
};

// Returns the volume that the steps from the stock to this step removed [mm^3].
double removed_until(const Document& document, StepId step);

}  // namespace kibori
