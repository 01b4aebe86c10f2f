// SPDX-License-Identifier: MIT
// One file: the stock, every stroke as the tool's own path, everything done with bodies, the tree
// of all that, and the models' state at some of its steps. SQLite, so that anyone can read it
// (docs/documents.md has the tables).
//
//   stock ── stroke ── stroke ── stroke*   every step knows the one before it
//                 └─── stroke ── stroke    going back and doing otherwise keeps the other
//
// Every step keeps the tiles that it changed, soon after it is finished: so going from one to
// another reads just what is different there. A step without any (its process ended, an older
// Kibori made it) is the nearest one before it that has some, and the strokes from there carved
// again: the same bytes, as a recorded path leaves them. States that were visited stay in memory,
// where they share what they have in common.
//
// What is added reaches the file at every flush(): a process that is killed then leaves an exact
// prefix. Where the file can't be written any more (a full disk), the document goes on in memory
// and says so; it can be saved again or elsewhere. A document belongs to one thread; one process
// writes a file, any number may read it meanwhile, as it was when they opened it.
#pragma once

#include <chrono>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include <kibori/base/bytes.h>
#include <kibori/base/result.h>
#include <kibori/body/workbench.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/motion/stroke_record.h>

namespace kibori {

using StepId = int64_t;

struct DocumentStorage;

struct Step {
  StepId id = 0, parent = 0;  // the stock has no parent: 0
  bool stock = false;
  bool action = false;   // with bodies (BodyAction); else, and but for the stock, a stroke
  BodyId body = 1;       // that a stroke worked on
  bool finished = true;  // else it was being made when its process ended
  std::string label;
  int64_t ticks = 0;
  double removed_mm3 = 0;  // negative: added
  uint64_t hash = 0;       // of all models after it: see Bodies
  int64_t made_s = 0;      // when it was begun [s since 1970]; 0: not known
  // Strokes with the same number have the same settings(); 0: the stock has none.
  int64_t setting = 0;
  bool pictured = false;  // there is a thumbnail of it
};

// A tick that was played again; of the second hand if recorded->second.
struct ReplayedTick {
  StepId step = 0;
  const StrokeTick* recorded = nullptr;
  ToolTick result;  // wrench: by the stroke's own force model, or the one asked for
  // What of which material a cut took, or a deposit put down, images included; else null.
  const Removed* removed = nullptr;
  double time_s = 0;  // since the stroke's beginning
};

class Document {
 public:
  enum class Access { write, read };

  // A new file; one that is there already is refused. `stock` says how the stock can be made again
  // (JSON); `source` is the file it came from, if any. Errors: the path, or another process writes
  // it.
  static Result<std::unique_ptr<Document>> create(const std::filesystem::path& path,
                                                  const TriDexel& model, const std::string& stock,
                                                  const Bytes& source = {},
                                                  const char* vfs = nullptr);
  // Errors: no document, one of a newer version, damage, or another process writes it (open it for
  // reading then). A stroke that was being made when its process ended is kept as far as it came.
  static Result<std::unique_ptr<Document>> open(const std::filesystem::path& path, Access access,
                                                const char* vfs = nullptr);
  ~Document();

  const std::string& name() const;
  // Why the file holds only the beginning, and all the rest is in memory; empty if all is well.
  const std::string& unsaved() const { return unsaved_; }
  // What may be missing of it, as a sentence: whoever wrote it did not close it, and the log that
  // then stands beside it, with the last steps, is not there. Empty if all is well.
  const std::string& missing() const { return missing_; }
  // Into the file again. Errors: it still can't be written; nothing has changed.
  Status save_again();
  // All of it into a new file, where the document then goes on. Errors: as of save_copy; nothing
  // has changed.
  Status move_to(const std::filesystem::path& path);
  const Lattice& lattice() const { return lattice_; }
  // As given to create().
  Result<std::string> stock() const;
  Result<Bytes> source() const;

  // The tree.
  const std::map<StepId, Step>& steps() const { return steps_; }
  StepId head() const { return head_; }
  // From the stock to `step`, both included. Errors: no such step.
  Result<std::vector<StepId>> path_to(StepId step) const;
  const std::map<std::string, StepId>& versions() const { return versions_; }
  // A step by number or version's name. Errors: neither.
  Result<StepId> find(const std::string& name) const;
  Status name_version(const std::string& name, StepId step);

  // Which bodies there are at a step; without their models.
  const Bodies& bodies_at(StepId step) const;
  // All at the head, with their models; null where no model is worked on (load).
  const Bodies* worked_on() const { return state_of(head_); }
  // The one that strokes go to: that of the head's stroke, unless it was chosen.
  BodyId active() const { return active_; }
  // Errors: the head has no such body. The caller's model goes there by checkout(head()).
  Status choose(BodyId body);

  // The active body's model at the head; what go, undo and redo work on from then on.
  Result<std::unique_ptr<TriDexel>> load();
  // A model of any step's active body; the document goes on at its head. Errors, here and of load,
  // go, undo and redo: what the file holds is not what was written there, by its hash; no model is
  // made of that.
  Result<std::unique_ptr<TriDexel>> load_at(StepId step) const;
  // All bodies at any step, with their models.
  Result<Bodies> load_bodies(StepId step) const;
  // The last step on the way to the head that is what was written. Error: not even the stock is.
  Result<StepId> last_whole() const;
  // Of a document that is only read: it is as if its head were there.
  Status stand_at(StepId step);
  // Makes `model` (from load() or given to create()) that of another step, which becomes the head.
  // Errors leave it as it was.
  Status go(TriDexel& model, StepId step);
  Status undo(TriDexel& model);
  Status redo(TriDexel& model);
  // Where undo and redo go: redo to the step last gone back from, or else the newest that follows.
  // Errors: nothing is there.
  Result<StepId> before_head() const;
  Result<StepId> after_head() const;

  // For a model (from load() or given to create()) that is on another thread: what to restore
  // there, and the box its material is in; commit_checkout() once that is done. Where it can't be
  // written, it can be tried again.
  struct Checkout {
    StepId step = 0;
    Bodies bodies;
    BodyId active = 1;
    Snapshot state;  // of the active one
    LatticeBox material_bounds;
    std::map<StepId, Bodies> states;  // come upon on the way

    Checkout() = default;
    Checkout(Checkout&&) = default;
    Checkout& operator=(Checkout&&) = default;
    // What was made beside the model goes back there.
    ~Checkout() {
      state.drop_shared();
      drop(bodies);
      for (auto& [step_id, made] : states) drop(made);
    }

   private:
    static void drop(Bodies& made) {
      for (Body& body : made.all) body.model.drop_shared();
    }
  };
  Result<Checkout> checkout(StepId step) const;
  Status commit_checkout(const Checkout& to);

  // What is done with bodies becomes a step, from the head on; the caller's model then goes to the
  // head by checkout(head()). Errors: as of apply(), or it can't be written; nothing has changed.
  Result<BodyChange> act(const BodyAction& action, int threads = 1);

  // What was done with bodies on the way to the head is done otherwise: beside that step there is a
  // new one, and what followed it on that way follows this one, done again. The old steps stay
  // where they are. The caller's model then goes to the head by checkout(head()). Errors: that step
  // is not on the way, or is a stroke; those of act(); something that followed can't be done any
  // more. Then the head is where it was.
  Status revise(StepId step, const BodyAction& action, int threads = 1);

  // A small picture of a step (PNG); empty if there is none.
  Status set_thumbnail(StepId step, const Bytes& png);
  Result<Bytes> thumbnail(StepId step) const;

  // A stroke from the head on. Ticks are kept until flush(), which is worth calling every 50 ms.
  // Errors, here and of flush and finish: neither file nor memory can be written; nothing is
  // dropped, and it can be tried again.
  Status begin(const StrokeSettings& settings, const Pose& start, const std::string& label = {});
  // `felt`: by the stroke's own force model; `given`: what the hand's device was given, within what
  // is safe. Each is kept too where every tick of the stroke has one.
  void add(const StrokeTick& tick, const Wrench* felt = nullptr, const Wrench* given = nullptr) {
    waiting_.push_back(tick);
    forces_.add(felt);
    given_.add(given);
  }
  bool in_stroke() const { return open_step_ != 0; }
  Status flush();
  // `model`: of the stroke's body, as the stroke left it, without what it severed; `severed`: what
  // of that are bodies now (take_crumbs). The stroke becomes the head.
  Status finish(const TriDexel& model, double removed_mm3,
                const std::vector<Portion>& severed = {}) {
    return finish(model.snapshot(), model.material_bounds(), removed_mm3, severed);
  }
  Status finish(const Snapshot& now, const LatticeBox& material_bounds, double removed_mm3,
                const std::vector<Portion>& severed = {});
  // The stroke is as if it had not been; the caller's model goes back to the head's state (go,
  // restore).
  Status cancel();

  // All of it, packed, into a new file, whole or not at all: another place when this one fails, or
  // a copy. This document goes on where it is. Errors: the path, or a file that is there already.
  Status save_copy(const std::filesystem::path& path) const;

  // The settings and ticks of a stroke.
  Result<StrokeSettings> settings(StepId step) const;
  Result<Pose> start(StepId step) const;
  // Calls f(ticks of one flush) for all of them.
  Status for_ticks(StepId step,
                   const std::function<Status(const std::vector<StrokeTick>&)>& f) const;
  // Calls f(force and moment of the ticks of one flush) for all of them, if they were kept: see
  // add().
  Status for_forces(StepId step, const std::function<Status(const std::vector<Wrench>&)>& f) const;
  // The same, of what the hand's device was given.
  Status for_given(StepId step, const std::function<Status(const std::vector<Wrench>&)>& f) const;
  // What was done with bodies.
  Result<BodyAction> action(StepId step) const;
  // Carves a stroke again on the bench, or does again what was done with bodies: all stands there
  // as it stood when the step began (at any pitch). `law`: another force model.
  Status replay(StepId step, Workbench& bench, const std::optional<ForceLaw>& law,
                const std::function<void(const ReplayedTick&)>& use) const;

  // Looks at everything there is: tables, tiles, ticks, and every step carved again. Calls
  // wrong(sentence) for all that is not as it should be; progress(share) now and then. Errors:
  // can't be read at all.
  Status verify(const std::function<void(const std::string&)>& wrong,
                const std::function<void(double)>& progress = {}) const;

 private:
  explicit Document(std::unique_ptr<DocumentStorage> storage);
  Error wrong(const std::string& what) const { return Error{name() + ": " + what}; }
  // As `wrong`, for what SQLite says.
  Error failed(const std::string& doing, const std::string& said) const {
    return wrong(doing + " failed: " + said);
  }
  // Opens and locks the file for writing.
  static Result<std::unique_ptr<Document>> attach(const std::filesystem::path& path,
                                                  const char* vfs);
  Status check_kind();
  Status check_tables();
  Status read_tree();
  Status recover();
  // All of `change` or none of it. Where the file can't be written, goes on in memory.
  Status commit(const char* doing, const std::function<Status()>& change);
  Status try_commit(const char* doing, const std::function<Status()>& change, bool& disk_failed);
  // Within a transaction: seals of a step that is finished, of all, and of the versions.
  Status seal(StepId step);
  Status seal_all();
  Status seal_versions();
  Status verify_seals(const std::function<void(const std::string&)>& wrong) const;
  // The file itself says while it is written that its log belongs to it.
  Status mark(bool writing);
  // Of a document that is whole so far: marks it, and starts the keeper of its log.
  Status begin_writing(const std::filesystem::path& path, const char* vfs);
  Status look_for_log(bool there);
  // Within a transaction. `sequence`: the number of the next block, once it is committed.
  Status write_ticks(int64_t& sequence);
  Status check_finished(StepId step) const;
  Status for_blocks(const char* table, StepId step,
                    const std::function<Status(const Bytes&, int64_t)>& f) const;
  // The tiles to keep of the state `now` of a step: those that are not as at the last step before
  // it that has any. They are kept little by little, as it takes time; all places in the end, at
  // once.
  struct TilePlace {
    int64_t field;  // see field_of
    int tu, tv;
    const Tile* tile;  // null: no material
  };
  struct TileJob {
    StepId step = 0;
    Bodies now;
    LatticeBox bounds;  // of the material of all
    bool planned = false;
    std::vector<TilePlace> places;
    size_t next = 0;
    std::unordered_map<const Tile*, int64_t> ids;
    bool done = false;
  };
  void wait_for_tiles(StepId step, const Bodies& now);
  Status plan_tiles(TileJob& job) const;
  // Within a transaction.
  Status keep_tiles(TileJob& job, std::chrono::steady_clock::time_point until);
  void keep_some_tiles(std::chrono::milliseconds at_most);
  // Which tile stands where at a step that has any; 0: none. Of all places, or of those that may be
  // others than at step `from`.
  using Place = std::tuple<int64_t, int64_t, int64_t>;  // field (see field_of), u, v
  using TileMap = std::map<Place, int64_t>;
  Result<TileMap> all_tiles(StepId step) const;
  Result<TileMap> other_tiles(StepId step, const std::vector<StepId>& way_from) const;
  // Those of one body.
  Status put_tiles(const TileMap& tiles, StepId step, BodyId body, TriDexel& model) const;
  // The bodies of a step that has tiles, made in the memory of `work`.
  Result<Bodies> read_tiles(StepId step, TriDexel& work) const;
  // The bodies of any step; `work` becomes the model of its active one.
  Result<Bodies> make_state(TriDexel& work, StepId step) const;
  // Whether the state of a finished step is what was written.
  Status check_state(StepId step, const Bodies& now) const;
  // The bodies of a step, by the states in memory and the tiles kept; `work` becomes the model of
  // its active one. remember(step, state) is told of those on the way.
  Result<Bodies> rebuild(TriDexel& work, StepId step,
                         const std::function<void(StepId, const Bodies&)>& remember) const;
  // The same, of a step that has tiles; `work` is left as it happens to be.
  Result<Bodies> go_by_tiles(TriDexel& work, StepId step) const;
  // The one that strokes go to after a step.
  BodyId active_at(StepId step) const;
  static void take_model(TriDexel& work, const Bodies& bodies, BodyId body);
  void list(StepId step, Bodies bodies);
  // Within a transaction.
  Status write_bodies(StepId step, const Bodies& bodies);
  // A step done again, from the head on.
  Status do_again(StepId step, int threads);
  Status carve_again(StepId step, const StrokeSettings& settings);
  Status replay_ticks(StepId step, const StrokeSettings& recorded, TriDexel& model,
                      const NoGo* no_go, const std::optional<ForceLaw>& law,
                      const std::function<void(const ReplayedTick&)>& use) const;
  bool is_checkpoint(StepId step) const { return checkpoints_.count(step) != 0; }
  void add_checkpoint(StepId step, const LatticeBox& bounds);
  const Bodies* state_of(StepId step) const {
    const auto found = states_.find(step);
    return found == states_.end() ? nullptr : &found->second;
  }
  Status set_head(StepId step);
  // Within a transaction.
  Status write_head(StepId step);
  void remember(StepId step, const Bodies& state);

  const std::unique_ptr<DocumentStorage> storage_;
  std::string unsaved_, missing_;
  bool writes_ = false;
  bool may_go_to_memory_ = false;
  int64_t version_ = 0;  // of the file's tables
  Lattice lattice_;
  std::map<StepId, Step> steps_;
  std::map<std::string, StepId> versions_;
  std::map<StepId, StepId> last_child_;            // gone back from
  std::map<StepId, LatticeBox> checkpoints_;       // and the material's bounds there
  std::unordered_set<StepId> before_checkpoints_;  // steps that a checkpoint follows
  std::deque<TileJob> tiles_;                      // that are being kept
  LatticeBox material_bounds_;                     // of all states
  StepId head_ = 0, open_step_ = 0;
  BodyId active_ = 1;
  std::map<StepId, Bodies> lists_;  // of steps after which there are other bodies; without models
  int64_t open_sequence_ = 0, saved_ticks_ = 0;
  std::vector<StrokeTick> waiting_;
  // Of the ticks that wait, where all that the stroke had by now have one.
  struct WaitingForces {
    const char* const table;
    std::vector<Wrench> rows = {};
    bool all = true;
    void add(const Wrench* row) {
      if (row)
        rows.push_back(*row);
      else
        all = false;
    }
  };
  WaitingForces forces_{"force"}, given_{"given"};
  void drop_waiting();
  bool marked_ = false;
  // States by step, of the one memory that is worked in.
  std::map<StepId, Bodies> states_;
  std::vector<StepId> visited_;
};

}  // namespace kibori
