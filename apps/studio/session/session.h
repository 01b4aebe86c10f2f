// SPDX-License-Identifier: MIT
// A session holds what the studio's pages show: a document that a user carves (LiveSession), a
// read-only document (HistoryViewer), or a scene that runs by itself (ExperimentSession). Sessions
// do not use the network or draw; apps/studio does. One thread owns a session.
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
  bool undo = false, redo = false;  // whether a target exists
  uint64_t hash = 0;                // of the model at `step`
  std::string write_error;          // see DocumentWriter::write_error()
};

struct PastStep {
  StepId id = 0, parent = 0;  // the stock's parent is 0
  double removed_mm3 = 0;     // negative: added
  int64_t made_s = 0;         // start of the step [s since 1970]; 0: unknown
  std::optional<Tool> tool;   // none for the stock
  Mode mode = Mode::cut;
  bool pictured = false;  // whether thumbnail() had a picture of it when the step was first listed
  std::string label;
};

struct SessionOptions {
  bool read_only = false;  // documents are open read-only
  // The device of devices/registry.h that holds the tool. Empty: a pointer.
  std::string device;
  // LiveSession::tick() moves the tool instead of a thread, so that a test's time is exact. Only a
  // pointer and the simulated hand can be stepped: a real device needs a tick every ms.
  bool stepped = false;
  // The device of the second hand's tool, if a device holds the first one's.
  std::string second = {};
};

class Session {
 public:
  using Versions = std::map<std::string, StepId>;

  virtual ~Session() = default;
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  // This session as one of its kinds, or null. live(): a hand carves. experiment(): a scene runs.
  // playback(): a milling job runs.
  virtual LiveSession* live() { return nullptr; }
  virtual ExperimentSession* experiment() { return nullptr; }
  virtual PlaybackSession* playback() { return nullptr; }  // of a milling job

  // The second hand's tool. Null: there is none.
  virtual const Tool* second_tool() const { return nullptr; }

  const Lattice& lattice() const { return lattice_; }
  const std::string& name() const { return name_; }  // of the document or the scene
  const std::vector<Material>& materials() const { return materials_; }
  uint8_t stock_material() const {
    return stock_material_;
  }  // the stock's material: an index of materials()
  double rate_hz() const { return rate_hz_; }

  // Updates the surfaces to the models. Call it every few ms. Returns the changed chunks.
  struct ChunkPlace {
    BodyId body = 1;
    Index3 at = Index3::Zero();
  };
  const std::vector<ChunkPlace>& follow();
  // All bodies with their models at the last follow(), and the active one.
  const BodyList& bodies() const { return shown_.bodies; }
  BodyId active() const { return shown_.active; }
  const Body& active_body() const { return *shown_.bodies.find(shown_.active); }
  const Snapshot& snapshot() const { return active_body().model; }
  // A revision. It increases whenever a body or its volume, or the active body, has changed.
  uint64_t bodies_revision() const { return bodies_revision_; }
  // Null: there is no such body.
  const LiveSurface* surface(BodyId body) const;
  // The volume of one body [mm^3]. The volume of the active body is counted only while no stroke
  // runs.
  double volume_mm3(BodyId body) const;
  // The ticks since the last call, oldest first.
  const std::vector<LiveTick>& ticks();
  // The total volume [mm^3] at the last follow() and ticks(), and the stock's volume minus this.
  double volume_mm3() const { return volume_mm3_; }
  double removed_mm3() const { return stock_mm3_ - volume_mm3_; }

  const HistoryState& history();
  // The steps in the order of their numbers, at the last history().
  const std::vector<PastStep>& steps() const { return steps_; }
  const Versions& versions() const { return versions_; }
  virtual void undo() {}
  virtual void redo() {}
  virtual void go(StepId) {}
  // Discards the stroke in progress. Stops an experiment.
  virtual void cancel() {}
  // Names the current step. notice() reports errors.
  virtual void name_version(const std::string& name);
  // Small pictures of steps (PNG). `use` is called on another thread, or at once. It receives an
  // empty picture if there is none.
  virtual void keep_thumbnail(StepId, Bytes) {}
  virtual void thumbnail(StepId step, std::function<void(Bytes)> use) = 0;
  // Writes the whole document, packed, into a new file. `done` is called on another thread, or at
  // once.
  virtual void save_copy(const std::filesystem::path& path, std::function<void(Status)> done) = 0;
  // A sentence for the user, or empty. Each one is returned once.
  virtual std::string notice() { return std::exchange(notice_, {}); }
  // Ends a stroke and saves. If the document's own file could not be written, returns a sentence
  // that says where the document is now.
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

  // The newest state, if it has changed since the last call. It has at least one body, and `active`
  // is one of them.
  virtual bool latest(Shown& shown) = 0;
  virtual bool next_tick(LiveTick&) { return false; }
  virtual void update_history() = 0;
  // True if the model keeps changing. Then its volume is not counted, because that takes time.
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
  bool cutting_ = false;  // at the last ticks()
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

// Opens a document with the tool and materials of its last stroke. If its head is damaged, opens
// the last undamaged step read-only. Errors: those of the document and the device.
Result<std::unique_ptr<Session>> open_session(const std::filesystem::path& document,
                                              const SessionOptions& options);
// Creates a document with the stock, tool and materials of `scene`. Errors: the file exists; those
// of the stock and the device; the session is read-only.
Result<std::unique_ptr<Session>> create_session(const std::filesystem::path& document,
                                                const Scene& scene, const SessionOptions& options);

// Converts a document's steps for pages. The thread that owns the document uses it.
class PastSteps {
 public:
  PastStep of(const Document& document, const Step& step);

 private:
  // Tool and mode by Step::setting, which many strokes share.
  std::map<int64_t, std::pair<std::optional<Tool>, Mode>> settings_;
};

// The volume removed on the path from the stock to a step [mm^3].
double removed_until(const Document& document, StepId step);

}  // namespace kibori
