// SPDX-License-Identifier: MIT
// A document is one file with the history of a work: the stock, every stroke as the path of the
// tool, and every action on bodies. These are its steps; they form a tree. The file also has the
// state of the models at some steps. It is an SQLite file, so other programs can read it.
// docs/documents.md describes the tables.
//
//   stock ── stroke ── stroke ── stroke*   every step knows its parent
//                 └─── stroke ── stroke    a new step after undo keeps the old branch
//
// Soon after a step ends, the document stores the tiles that the step changed. Such a step is a
// checkpoint. To move from one checkpoint to another, the document reads only the tiles that
// differ. Some steps are no checkpoints, because their process was killed or an older Kibori made
// them. To make the state of such a step, the document starts at the nearest earlier checkpoint and
// carves the strokes since then again. This gives the same bytes. States that were visited stay in
// memory, and share equal tiles.
//
// Every flush() writes new data to the file. If the process is killed, the file has everything up
// to the last flush. If the file becomes unwritable (for example, the disk is full), the document
// continues in memory. unsaved() reports this, and the document can be saved again, in the same
// file or elsewhere. A document belongs to one thread. One process may write a file. At the same
// time, any number of processes may read it. Each reader sees the state at which it opened the
// file.
#pragma once

#include <array>
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

class Database;
struct DocumentStorage;
enum class BlockTable;

// A step of the history: the stock, a stroke, or an action on bodies.
struct Step {
  StepId id = 0, parent = 0;  // 0 for the stock, which has no parent
  bool stock = false;
  bool action = false;   // true for an action on bodies (BodyAction)
  BodyId body = 1;       // the body that a stroke worked on
  bool finished = true;  // false: the process ended during the stroke
  std::string label;
  int64_t ticks = 0;
  double removed_mm3 = 0;  // negative: added
  uint64_t hash = 0;       // hash of all models after the step: see Bodies
  int64_t made_s = 0;      // time at which the step began [s since 1970]; 0: unknown
  // Number of the settings. Strokes with the same number have the same settings(). 0 for the stock.
  int64_t setting = 0;
  bool pictured = false;  // true if the step has a thumbnail
};

// One tick of a replay. If recorded->second is true, it is a tick of the second hand.
struct ReplayedTick {
  StepId step = 0;
  const RecordedTick* recorded = nullptr;
  ToolTick result;  // the wrench is that of the stroke's force model, or of the requested one
  // The volume that a cut removed or a deposit added, for each material, with the images. Null if
  // the tick did neither.
  const Removed* removed = nullptr;
  double time_s = 0;  // since the start of the stroke
};

class Document {
 public:
  enum class Access { write, read };

  // Creates a new file. `stock` is JSON that describes how to make the stock again. `source` is the
  // content of the stock's file, if there is one. Errors: the path is invalid; the file exists; it
  // cannot be written.
  static Result<std::unique_ptr<Document>> create(const std::filesystem::path& path,
                                                  const TriDexel& model, const std::string& stock,
                                                  const Bytes& source = {},
                                                  const char* vfs = nullptr);
  // Opens a document. If a process was killed during a stroke, the document has the stroke up to
  // that point. With Access::read, no file is changed. Errors: the file is not a document, is of a
  // newer version, or has nothing that can be read; a -wal file of another document is next to it.
  // More errors for Access::write: a row is damaged (see damage()); another process writes the
  // file; the file is not writable.
  static Result<std::unique_ptr<Document>> open(const std::filesystem::path& path, Access access,
                                                const char* vfs = nullptr);
  ~Document();

  const std::string& name() const;
  // Returns the reason why the file lacks the newest data, which is only in memory. Empty if the
  // file is complete.
  const std::string& unsaved() const { return unsaved_; }
  // Returns a sentence for the user if the last steps may be missing: a writer was killed, and the
  // log with its last steps is not next to the file. Empty if nothing is missing.
  const std::string& missing() const { return missing_; }
  // Returns a sentence about the first damaged row of steps, bodies, settings or versions. When the
  // document was opened, the row was missing, or differed from what was written. Empty if there is
  // none.
  std::string damage() const { return damage_.empty() ? std::string() : damage_.front(); }
  // Returns Ok if the rows of all steps on the path to `step` are undamaged. load, load_at and
  // load_bodies make the same check. If `step` is the head, its number must also be undamaged.
  Status check_rows(StepId step) const;
  // Tries to write everything into the file again. Errors: the file is still not writable; nothing
  // has changed.
  Status save_again();
  // Writes the whole document into a new file, and continues there. Errors: the document is
  // read-only; the errors of save_copy. After an error, the document continues in its own file.
  Status move_to(const std::filesystem::path& path);
  const Lattice& lattice() const { return lattice_; }
  // Return the values that were passed to create().
  Result<std::string> stock() const;
  Result<Bytes> source() const;

  // The tree of steps.
  const std::map<StepId, Step>& steps() const { return steps_; }
  StepId head() const { return head_; }
  // Returns the head that the file names. It differs from head() if that step is missing or
  // unfinished, or after view_step().
  StepId head_in_file() const { return head_in_file_; }
  // Returns the path from the stock to `step`, with both. Errors: there is no such step.
  Result<std::vector<StepId>> path_to(StepId step) const;
  const std::map<std::string, StepId>& versions() const { return versions_; }
  // Finds a step by its number or by the name of a version. Errors: there is no such step; the
  // versions are damaged.
  Result<StepId> find(const std::string& name) const;
  // Gives a finished step a name. Errors: the name is empty or a number; the step is not finished.
  Status name_version(const std::string& name, StepId step);

  // Returns the bodies at a step, without their models.
  const BodyList& bodies_at(StepId step) const;
  // Returns all bodies at the head, with their models. Null if no model was loaded (load).
  const BodyList* worked_on() const { return state_of(head_); }
  // Returns the body on which strokes act: the body of the head's stroke, or that of choose().
  BodyId active() const { return active_; }
  // Selects the body for strokes. Then the caller's model must get the state of checkout(head()).
  // Errors: the head has no such body.
  Status choose(BodyId body);

  // Makes the model of the active body at the head. After this call, go, undo and redo change it.
  Result<std::unique_ptr<TriDexel>> load();
  // Makes a model of the active body of any step. The head does not change. Errors of this function
  // and of load, go, undo and redo: a row is damaged; the stored data does not match its hash.
  Result<std::unique_ptr<TriDexel>> load_at(StepId step) const;
  // Makes the models of all bodies at any step.
  Result<BodyList> load_bodies(StepId step) const;
  // Makes the model of the stock, even if the stock's row is damaged. For salvage.
  Result<std::unique_ptr<TriDexel>> load_stock() const;
  // Returns the last undamaged step on the path to the head. Errors: even the stock is damaged.
  Result<StepId> last_whole() const;
  // For a document that is open for reading: sets the head of this object. The file does not
  // change.
  Status view_step(StepId step);
  // Changes `model` to the state of another step, which becomes the head. `model` is from load(),
  // or was passed to create(). After an error, `model` is unchanged.
  Status go(TriDexel& model, StepId step);
  Status undo(TriDexel& model);
  Status redo(TriDexel& model);
  // Return the targets of undo and redo. redo goes to the step that undo left last. If there is
  // none, it goes to the newest child of the head. Errors: there is no such step.
  Result<StepId> before_head() const;
  Result<StepId> after_head() const;

  // Moves the head for a model that another thread owns. (The model is from load(), or was passed
  // to create().) checkout() returns the state to restore there, and the box of its material. Call
  // commit_checkout() after the restore. If writing fails, the call can be repeated.
  struct Checkout {
    StepId step = 0;
    BodyList bodies;
    BodyId active = 1;
    Snapshot state;  // state of the active body
    LatticeBox material_bounds;
    std::map<StepId, BodyList> states;  // states of all steps on the path that were made

    Checkout() = default;
    Checkout(Checkout&&) = default;
    Checkout& operator=(Checkout&&) = default;
    // Returns the memory that is shared with the model.
    ~Checkout() {
      state.drop_shared();
      drop(bodies);
      for (auto& [step_id, made] : states) drop(made);
    }

   private:
    static void drop(BodyList& made) {
      for (Body& body : made.all) body.model.drop_shared();
    }
  };
  Result<Checkout> checkout(StepId step) const;
  Status commit_checkout(const Checkout& to);

  // Applies an action on bodies as a step after the head. Then the caller's model must get the
  // state of checkout(head()). Errors: those of apply(); the document is read-only or in a stroke;
  // writing fails. After an error, nothing has changed.
  Result<BodyChange> act(const BodyAction& action, int threads = 1);

  // Changes an earlier action on the path to the head. First adds the changed action as a new step
  // next to the old one. Then repeats the later steps after it. The old steps stay. Then the
  // caller's model must get the state of checkout(head()). Errors: the step is not on the path, or
  // is not an action; act() fails; a later step is no longer possible. After an error, the head is
  // the old one, but new steps may remain.
  Status revise(StepId step, const BodyAction& action, int threads = 1);

  // A thumbnail is a small picture of a step (PNG). thumbnail() returns empty bytes if there is
  // none.
  Status set_thumbnail(StepId step, const Bytes& png);
  Result<Bytes> thumbnail(StepId step) const;

  // Begins a stroke after the head. The ticks of add() wait in memory until flush(). Call flush()
  // about every 50 ms. Errors: the stroke is impossible (body, modes, settings), or the document is
  // read-only or in a stroke. Errors of begin, flush and finish: neither the file nor memory is
  // writable. Then nothing is lost, and the call can be repeated.
  Status begin(const StrokeSettings& settings, const Pose& start, const std::string& label = {});
  // Adds a tick to the stroke. `computed` is the force of the stroke's own force model. `given` is
  // the force that the hand's device received from the safety stage. The document stores each of
  // them only if every tick of the stroke has it.
  void add(const RecordedTick& tick, const Wrench* computed = nullptr,
           const Wrench* given = nullptr) {
    waiting_.push_back(tick);
    forces_.add(computed);
    given_.add(given);
  }
  bool in_stroke() const { return open_step_ != 0; }
  Status flush();
  // Ends the stroke, which becomes the head. `model` is the model of the stroke's body, without the
  // severed pieces. `severed` lists the severed pieces that become bodies (take_crumbs).
  Status finish(const TriDexel& model, double removed_mm3,
                const std::vector<Portion>& severed = {}) {
    return finish(model.snapshot(), model.material_bounds(), removed_mm3, severed);
  }
  Status finish(const Snapshot& now, const LatticeBox& material_bounds, double removed_mm3,
                const std::vector<Portion>& severed = {});
  // Removes the current stroke. The caller must restore the model to the state of the head.
  Status cancel();

  // Writes a compact copy into a new file, completely or not at all. The document continues in its
  // own file. Errors: the path is invalid; the file exists; it cannot be written.
  Status save_copy(const std::filesystem::path& path) const;

  // Return the settings and the start of a stroke.
  Result<StrokeSettings> settings(StepId step) const;
  Result<Pose> start(StepId step) const;
  // Calls f(ticks) for the ticks of each flush.
  Status for_ticks(StepId step,
                   const std::function<Status(const std::vector<RecordedTick>&)>& f) const;
  // Calls f(wrenches) with the computed forces of each flush, if they were stored: see add().
  Status for_forces(StepId step, const std::function<Status(const std::vector<Wrench>&)>& f) const;
  // Like for_forces(), for the forces that the hand's device received.
  Status for_given(StepId step, const std::function<Status(const std::vector<Wrench>&)>& f) const;
  // Returns the action of a step.
  Result<BodyAction> action(StepId step) const;
  // Repeats a stroke or an action on the bench. The bodies on the bench must have the state before
  // the step, at any pitch. `law` replaces the stroke's force model.
  Status replay(StepId step, Workbench& bench, const std::optional<ForceLaw>& law,
                const std::function<void(const ReplayedTick&)>& use) const;

  // Checks tables, tiles, ticks, and every step by a replay. Calls wrong(sentence) for every
  // problem, note(sentence) for remarks, and progress(share) from time to time. Errors: the file
  // cannot be read at all.
  Status verify(const std::function<void(const std::string&)>& wrong,
                const std::function<void(double)>& progress = {},
                const std::function<void(const std::string&)>& note = {}) const;

 private:
  explicit Document(std::unique_ptr<DocumentStorage> storage);
  Error wrong(const std::string& what) const { return Error{name() + ": " + what}; }
  // Like wrong(), for an error of SQLite.
  Error failed(const std::string& doing, const std::string& reason) const;
  // Opens and locks the file for writing, but writes nothing.
  static Result<std::unique_ptr<Document>> attach(const std::filesystem::path& path,
                                                  const char* vfs);
  // Opens the file for reading. If a writer was killed, opens a private copy of it.
  static Result<std::unique_ptr<Document>> attach_reader(const std::filesystem::path& path,
                                                         const char* vfs);
  // Returns a sentence if pages are missing at the end of the file and are not in its log.
  // Otherwise, returns an empty text. Errors: a -wal or -journal file next to the document belongs
  // to another one.
  static Result<std::string> check_logs(const std::filesystem::path& path);
  // Opens a private copy of the document and its logs. Errors: those of check_logs; the copy cannot
  // be made; a process writes the file and `may_be_held` is false.
  static Result<Database> open_copy(const std::filesystem::path& path, bool may_be_held);
  // Returns a sentence if pages are missing at the end of the file; otherwise, an empty text.
  static std::string missing_pages(const std::filesystem::path& path);
  // Returns a value of the table `meta`. Empty if there is none, or if this is not a document of
  // Kibori.
  static std::string meta_of(Database& database, const char* key);
  // Returns true if the structure and the rows of a database are those of a complete document. The
  // rows of a newer format are not checked.
  static bool is_complete(Database& database);
  Status check_kind();
  bool is_newer() const;  // true if this version of Kibori cannot read the format
  Status check_tables();
  Status read_tree();
  // path_fault() returns the first damage on the path to `step`, or an empty text. row_fault()
  // returns the same, but for the head, it returns damage() if the number of the head is lost.
  std::string path_fault(StepId step) const;
  std::string row_fault(StepId step) const;
  // Adds a damage that was found when the document was opened. step 0: it belongs to no certain
  // step.
  void add_damage(StepId step, const std::string& fault);
  Status recover();
  // Applies all of `change` or nothing, as one transaction. If the file is not writable, the
  // document continues in memory.
  Status commit(const char* doing, const std::function<Status()>& change);
  Status try_commit(const char* doing, const std::function<Status()>& change, bool& disk_failed);
  // Call these within a transaction. They seal a finished step, all steps, and the versions. A seal
  // is a hash that shows damage.
  Status seal(StepId step);
  Status seal_all();
  Status seal_versions();
  // Calls wrong(step, sentence) for each damaged row. step 0: the row belongs to no certain step.
  Status check_seals(const std::function<void(StepId, const std::string&)>& wrong) const;
  // Calls check_seals() when the document is opened. Stores the damage, and reads sealed_blocks_.
  void look_at_seals();
  // Call it within a transaction. Writes the number of this commit into `meta`. So every log
  // contains such a number, which shows to which file the log belongs.
  Status count_commit();
  // Writes or removes a mark in the file: a process writes this document. While the mark exists, a
  // log must be next to the file. If it is not, the last steps are missing.
  Status mark(bool writing);
  // For a document without damage: brings its tables up to date.
  Status prepare_writing();
  // For a complete document: writes the mark, and starts the keeper of the log.
  Status begin_writing(const std::filesystem::path& path, const char* vfs);
  Status look_for_log(bool there);
  // Call it within a transaction. `sequence` becomes the number of the next block after the commit.
  Status write_ticks(int64_t& sequence);
  Status check_finished(StepId step) const;
  Status for_blocks(BlockTable table, StepId step,
                    const std::function<Status(const Bytes&, int64_t)>& f) const;
  // The tiles to store for the state `now` of a step: those that differ from the nearest earlier
  // checkpoint. Storing them takes time, so each flush() stores only some. Their places are written
  // at the end, in one transaction.
  struct TilePlace {
    int64_t field;  // see field_of()
    int tu, tv;
    const Tile* tile;  // null: the tile has no material
  };
  struct TileJob {
    StepId step = 0;
    BodyList now;
    LatticeBox bounds;  // box of the material of all bodies
    bool planned = false;
    std::vector<TilePlace> places;
    size_t next = 0;
    std::unordered_map<const Tile*, int64_t> ids;
    bool done = false;
  };
  void wait_for_tiles(StepId step, const BodyList& now);
  Status plan_tiles(TileJob& job) const;
  // Call it within a transaction.
  Status keep_tiles(TileJob& job, std::chrono::steady_clock::time_point until);
  void keep_some_tiles(std::chrono::milliseconds max_time);
  // The tile at each place of a checkpoint; 0: no tile. all_tiles() returns all places.
  // other_tiles() returns the places that may differ from the step at the start of `path_from`.
  using Place = std::tuple<int64_t, int64_t, int64_t>;  // field (see field_of), u, v
  using TileMap = std::map<Place, int64_t>;
  Result<TileMap> all_tiles(StepId step) const;
  Result<TileMap> other_tiles(StepId step, const std::vector<StepId>& path_from) const;
  // Writes the tiles of one body into `model`.
  Status put_tiles(const TileMap& tiles, StepId step, BodyId body, TriDexel& model) const;
  // Returns the bodies of a checkpoint, in the memory of `work`.
  Result<BodyList> read_tiles(StepId step, TriDexel& work) const;
  // Like read_tiles(), but begins with `before`, and reads only the tiles of this step. `before`
  // has the bodies of the nearest earlier checkpoint, in the same memory.
  Result<BodyList> read_tiles_after(const BodyList& before, StepId step, TriDexel& work) const;
  Result<BodyList> put_bodies(const TileMap& tiles, const BodyList& start, StepId step,
                              const LatticeBox& bounds, TriDexel& work) const;
  // Returns the bodies of any step. `work` becomes the model of the active body.
  Result<BodyList> make_state(TriDexel& work, StepId step) const;
  // Returns Ok if the state of a finished step matches its hash.
  Status check_state(StepId step, const BodyList& now) const;
  // Returns the bodies of a step, from the states in memory and the stored tiles. `work` becomes
  // the model of the active body. Calls remember(step, state) for the states on the path.
  Result<BodyList> rebuild(TriDexel& work, StepId step,
                           const std::function<void(StepId, const BodyList&)>& remember) const;
  // Like rebuild(), for a checkpoint. The state of `work` afterwards is unspecified.
  Result<BodyList> go_by_tiles(TriDexel& work, StepId step) const;
  // Returns the body on which strokes act after a step.
  BodyId active_at(StepId step) const;
  static void take_model(TriDexel& work, const BodyList& bodies, BodyId body);
  void list(StepId step, BodyList bodies);
  // Call it within a transaction.
  Status write_bodies(StepId step, const BodyList& bodies);
  // Repeats an earlier step as a new step after the head.
  Status do_again(StepId step, int threads);
  Status carve_again(StepId step, const StrokeSettings& settings);
  Status set_first_lattice(const StrokeSettings& settings, TriDexel& model) const;
  LatticeBox bounds_at(StepId step) const;
  Status replay_ticks(StepId step, const StrokeSettings& recorded, TriDexel& model,
                      const NoGo* no_go, const std::optional<ForceLaw>& law,
                      const std::function<void(const ReplayedTick&)>& use) const;
  bool is_checkpoint(StepId step) const { return checkpoints_.count(step) != 0; }
  void add_checkpoint(StepId step, const LatticeBox& bounds);
  const BodyList* state_of(StepId step) const {
    const auto found = states_.find(step);
    return found == states_.end() ? nullptr : &found->second;
  }
  Status set_head(StepId step);
  // Call it within a transaction.
  Status write_head(StepId step);
  void remember(StepId step, const BodyList& state);

  const std::unique_ptr<DocumentStorage> storage_;
  std::string unsaved_, missing_;
  std::vector<std::string> damage_;
  std::map<StepId, std::string> broken_;  // the first damage of each damaged step
  // Hashes of each step's rows in `tick`, `force` and `given`, from the seal of the step.
  std::map<StepId, std::array<uint64_t, 3>> sealed_blocks_;
  bool head_lost_ = false;         // true if the file's head is not a readable step
  bool versions_changed_ = false;  // true if they differ from what was sealed
  bool writes_ = false;
  bool may_go_to_memory_ = false;
  int64_t version_ = 0;  // format version of the file
  Lattice lattice_;
  std::map<StepId, Step> steps_;
  std::map<std::string, StepId> versions_;
  std::map<StepId, StepId> last_child_;            // the child that undo left last
  std::map<StepId, LatticeBox> checkpoints_;       // bounds of the material of each checkpoint
  std::unordered_set<StepId> before_checkpoints_;  // steps that have a later checkpoint
  std::deque<TileJob> tiles_;                      // tiles that are not stored yet
  LatticeBox material_bounds_;                     // box of the material of all states
  StepId head_ = 0, head_in_file_ = 0, open_step_ = 0;
  BodyId active_ = 1;
  std::map<StepId, BodyList> lists_;  // bodies of steps that change the list, without models
  int64_t open_sequence_ = 0, saved_ticks_ = 0;
  std::vector<RecordedTick> waiting_;
  // The forces of the waiting ticks. `all` is true while every tick of the stroke has a force.
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
  // Identifies this writer and the previous one, for the numbers of commits. Empty: commits are not
  // counted.
  std::string session_, before_session_;
  int64_t commits_ = 0;
  // The states of steps in memory. All share the memory of the current model.
  std::map<StepId, BodyList> states_;
  std::vector<StepId> visited_;
};

}  // namespace kibori
