// SPDX-License-Identifier: MIT
// What the studio's pages look at: a document that a hand carves in (LiveSession), one that is only
// looked at (HistoryViewer), or a scene that carves by itself (ExperimentSession). No network, no
// picture: see apps/studio for those. All of a session belongs to one thread, the owner's.
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

// Where a document stands.
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

struct SessionOptions {
  bool read_only = false;  // documents are only looked at
  // A name of devices/registry.h that holds the tool; empty: a pointer does.
  std::string device;
  // No thread of its own moves the tool, but LiveSession::tick() does: a test's time is then exact.
  // Only a pointer and the simulated hand can be stepped: no one would let go of a real device.
  bool stepped = false;
  // As device, of the second hand's tool, where a device holds the first's.
  std::string second = {};
};

class Session {
 public:
  using Versions = std::map<std::string, StepId>;

  virtual ~Session() = default;
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  // Null, unless a hand carves or a scene does.
  virtual LiveSession* live() { return nullptr; }
  virtual ExperimentSession* experiment() { return nullptr; }

  // Of the second hand; null: there is none.
  virtual const Tool* second_tool() const { return nullptr; }

  const Lattice& lattice() const { return lattice_; }
  const std::string& name() const { return name_; }  // of the document or the scene
  const std::vector<Material>& materials() const { return materials_; }
  uint8_t stock_material() const {
    return stock_material_;
  }  // what the stock is of: a number of materials()
  double rate_hz() const { return rate_hz_; }

  // To be called every few ms: the surfaces follow the models. The chunks that changed.
  struct ChunkPlace {
    BodyId body = 1;
    Index3 at = Index3::Zero();
  };
  const std::vector<ChunkPlace>& follow();
  // All bodies with their models, as of the last follow(), and which of them is worked on.
  const Bodies& bodies() const { return shown_.bodies; }
  BodyId active() const { return shown_.active; }
  const Body& active_body() const { return *shown_.bodies.find(shown_.active); }
  const Snapshot& snapshot() const { return active_body().model; }
  // Another number whenever any of this is another.
  uint64_t bodies_told() const { return bodies_told_; }
  // Null: there is no such body.
  const LiveSurface* surface(BodyId body) const;
  // Of one body [mm^3], as of when it was not worked on last.
  double volume_mm3(BodyId body) const;
  // Ticks since the last call, oldest first.
  const std::vector<LiveTick>& ticks();
  // Volume [mm^3] of all, as of the last follow() and ticks(); and how much less that is than the
  // stock's.
  double volume_mm3() const { return volume_mm3_; }
  double removed_mm3() const { return stock_mm3_ - volume_mm3_; }

  const HistoryState& history();
  // What was done, in the order of its numbers, as of the last history().
  const std::vector<PastStep>& steps() const { return steps_; }
  const Versions& versions() const { return versions_; }
  virtual void undo() {}
  virtual void redo() {}
  virtual void go(StepId) {}
  // A stroke that is being made is as if it had not been; an experiment stops.
  virtual void cancel() {}
  // Of the step that the document stands at; what can't be is told by notice().
  virtual void name_version(const std::string& name);
  // Small pictures of steps (PNG). `use` is called on another thread, or at once, with nothing
  // where there is none.
  virtual void keep_thumbnail(StepId, Bytes) {}
  virtual void thumbnail(StepId step, std::function<void(Bytes)> use) = 0;
  // All of the document, packed, into a new file; `done` is called on another thread, or at once.
  virtual void save_copy(const std::filesystem::path& path, std::function<void(Status)> done) = 0;
  // A sentence for the person; empty where there is none. Taken away by asking.
  virtual std::string notice() { return std::exchange(notice_, {}); }
  // Ends a stroke, and saves. A sentence on where the document is, if not where it belongs.
  virtual std::string close() { return {}; }

 protected:
  Session() = default;
  struct Shown {
    Bodies bodies;
    BodyId active = 1;
  };
  // The first state; the stock had `removed_mm3` more.
  void begin(Shown first, double removed_mm3);
  void notify(const Status& how) {
    if (!how) notice_ = how.error();
  }

  // The newest state, where it is another than the last one: at least one body, and `active` is one
  // of them.
  virtual bool latest(Shown& shown) = 0;
  virtual bool next_tick(LiveTick&) { return false; }
  virtual void update_history() = 0;
  // Whether the model changes all the time: its volume is then not counted, as that takes a while.
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
  bool cutting_ = false;  // as of the last ticks()
  bool volume_known_ = false;

 private:
  void count_volume();
  struct Seen {
    LiveSurface surface;
    double volume_mm3 = 0;
  };
  Shown shown_;
  std::map<BodyId, Seen> seen_;
  uint64_t bodies_told_ = 1;
  std::vector<ChunkPlace> changed_;
  double volume_mm3_ = 0, stock_mm3_ = 0;
};

// A document that is there, with the tool and materials of its last stroke; its last step that is
// whole, only to be looked at, where what follows is damaged. Errors: those of the document and the
// device.
Result<std::unique_ptr<Session>> open_session(const std::filesystem::path& document,
                                              const SessionOptions& options);
// A new document of the stock, tool and materials of `scene`. Errors: it is there already; those of
// the stock and the device; it is only to be looked at.
Result<std::unique_ptr<Session>> create_session(const std::filesystem::path& document,
                                                const Scene& scene, const SessionOptions& options);

// Steps of a document as pages have them; of the thread that has the document.
class PastSteps {
 public:
  PastStep of(const Document& document, const Step& step);

 private:
  // Tool and mode by Step::setting: many strokes share them.
  std::map<int64_t, std::pair<std::optional<Tool>, Mode>> settings_;
};

// What was removed on the way from the stock to a step [mm^3].
double removed_until(const Document& document, StepId step);

}  // namespace kibori
