// SPDX-License-Identifier: MIT
// A document is one file. It holds the stock, every stroke as the path of the tool, every action on
// bodies, and the tree of these steps. It also holds the models' state at some steps. It is an
// SQLite file, so anyone can read it. docs/documents.md describes the tables.
//
//   stock ── stroke ── stroke ── stroke*   every step knows its parent
//                 └─── stroke ── stroke    a new step after undo keeps the old branch
//
// Soon after a step ends, the document stores the tiles that the step changed. Therefore, a move
// from one step to another only reads the differences. Some steps have no tiles, because their
// process was killed or an older Kibori made them. Their state is rebuilt from the nearest earlier
// step with tiles: the strokes since then are carved again, which gives the same bytes. Visited
// states stay in memory and share their common tiles.
//
// Every flush() writes new data to the file. If the process is killed, the file has everything up
// to the last flush. If the file is no longer writable (a full disk), the document continues in
// memory and reports it. It can then be saved again or elsewhere. A document belongs to one thread.
// One process writes a file. Any number may read it at the same time. Each sees the state at which
// it opened the file.
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
  StepId id = 0, parent = 0;  // the stock has no parent: 0
  bool stock = false;
  bool action = false;   // on bodies (BodyAction); false for a stroke or the stock
  BodyId body = 1;       // the body that a stroke worked on
  bool finished = true;  // false: its process ended during the stroke
  std::string label;
  int64_t ticks = 0;
  double removed_mm3 = 0;  // negative: added
  uint64_t hash = 0;       // of all models after it: see Bodies
  int64_t made_s = 0;      // time of its start [s since 1970]; 0: unknown
  // Strokes with the same number have the same settings(). The stock has none: 0.
  int64_t setting = 0;
  bool pictured = false;  // a thumbnail exists
};

// A tick of a replay. It is of the second hand if recorded->second.
struct ReplayedTick {
  StepId step = 0;
  const RecordedTick* recorded = nullptr;
  ToolTick result;  // wrench: by the stroke's own force model, or by the requested one
  // The volume that a cut removed or a deposit added, by material, including images; otherwise
  // null.
  const Removed* removed = nullptr;
  double time_s = 0;  // since the start of the stroke
};

class Document {
 public:
  enum class Access { write, read };

  // Creates a new file; an existing file is an error. `stock` describes as JSON how to make the
  // stock again. `source` is the content of the stock's file, if it has one. Errors: an invalid
  // path, or another process writes the file.
  static Result<std::unique_ptr<Document>> create(const std::filesystem::path& path,
                                                  const TriDexel& model, const std::string& stock,
                                                  const Bytes& source = {},
                                                  const char* vfs = nullptr);
  // Errors: the file is not a document, is of a newer version, or is so damaged that nothing can be
  // read; a -wal file of another document is next to it. For writing also: any damage of its rows
  // (see damage()), or another process writes it. If a process was killed during a stroke, the
  // stroke up to that point is kept. A document that is open for reading changes no file.
  static Result<std::unique_ptr<Document>> open(const std::filesystem::path& path, Access access,
                                                const char* vfs = nullptr);
  ~Document();

  const std::string& name() const;
  // The reason why the file has only the beginning, and memory has the rest. Empty if the file is
  // complete.
  const std::string& unsaved() const { return unsaved_; }
  // A sentence that the last steps may be missing: the writer did not close the document, and the
  // log with its last steps is not next to it. Empty if nothing is missing.
  const std::string& missing() const { return missing_; }
  // A sentence about the first row of steps, bodies, settings or versions that is damaged. It was
  // missing, or not what was written, when the document was opened. Empty if there is none.
  std::string damage() const { return damage_.empty() ? std::string() : damage_.front(); }
  // Ok if the rows of all steps on the path to `step` are undamaged. load, load_at and load_bodies
  // call it. If `step` is the head, it also checks that the number of the head is undamaged.
  Status check_rows(StepId step) const;
  // Tries to write everything into the file again. Errors: the file is still not writable; nothing
  // has changed.
  Status save_again();
  // Moves the whole document into a new file, where it continues. Errors: see save_copy; nothing
  // has changed.
  Status move_to(const std::filesystem::path& path);
  const Lattice& lattice() const { return lattice_; }
  // As passed to create().
  Result<std::string> stock() const;
  Result<Bytes> source() const;

  // The tree.
  const std::map<StepId, Step>& steps() const { return steps_; }
  StepId head() const { return head_; }
  // The head in the file. It differs from head() if that step is missing or unfinished, or after
  // view_step().
  StepId head_in_file() const { return head_in_file_; }
  // The path from the stock to `step`, both included. Errors: no such step.
  Result<std::vector<StepId>> path_to(StepId step) const;
  const std::map<std::string, StepId>& versions() const { return versions_; }
  // Finds a step by number or by version name. Errors: neither exists.
  Result<StepId> find(const std::string& name) const;
  Status name_version(const std::string& name, StepId step);

  // The bodies at a step, without their models.
  const BodyList& bodies_at(StepId step) const;
  // All bodies at the head, with their models; null if no model was loaded (load).
  const BodyList* worked_on() const { return state_of(head_); }
  // The body that strokes act on: that of the head's stroke, unless choose() was called.
  BodyId active() const { return active_; }
  // Errors: the head has no such body. The caller's model then needs checkout(head()).
  Status choose(BodyId body);

  // The active body's model at the head. After this call, go, undo and redo work on it.
  Result<std::unique_ptr<TriDexel>> load();
  // A model of the active body of any step. The head does not change. Errors of this and of load,
  // go, undo and redo: the stored data does not match its hash. No model is made of such data.
  Result<std::unique_ptr<TriDexel>> load_at(StepId step) const;
  // All bodies at any step, with their models.
  Result<BodyList> load_bodies(StepId step) const;
  // The model of the stock, even if its row is damaged. For salvage.
  Result<std::unique_ptr<TriDexel>> load_stock() const;
  // The last undamaged step on the path to the head. Error: not even the stock is undamaged.
  Result<StepId> last_whole() const;
  // For a document that is open for reading: sets the head for this object only.
  Status view_step(StepId step);
  // Changes `model` (from load(), or passed to create()) to the state of another step, which
  // becomes the head. An error leaves it unchanged.
  Status go(TriDexel& model, StepId step);
  Status undo(TriDexel& model);
  Status redo(TriDexel& model);
  // The targets of undo and redo. Redo goes to the step that was left last by undo, otherwise to
  // the newest child. Errors: there is none.
  Result<StepId> before_head() const;
  Result<StepId> after_head() const;

  // For a model (from load(), or passed to create()) that another thread owns. A Checkout has the
  // state to restore there, and the box of its material. Call commit_checkout() after the restore.
  // If the write fails, the call can be repeated.
  struct Checkout {
    StepId step = 0;
    BodyList bodies;
    BodyId active = 1;
    Snapshot state;  // of the active body
    LatticeBox material_bounds;
    std::map<StepId, BodyList> states;  // states found on the path

    Checkout() = default;
    Checkout(Checkout&&) = default;
    Checkout& operator=(Checkout&&) = default;
    // Returns memory that is shared with the model.
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

  // Applies an action on bodies as a step after the head. The caller's model then needs
  // checkout(head()). Errors: see apply(), or the write failed; nothing has changed.
  Result<BodyChange> act(const BodyAction& action, int threads = 1);

  // Changes an earlier action on the path to the head. It adds the changed action as a new step
  // next to the old one, and then repeats the later steps after it. The old steps stay. The
  // caller's model then needs checkout(head()). Errors: the step is not on the path, or is a
  // stroke; errors of act(); a later step is no longer possible. An error leaves the head
  // unchanged.
  Status revise(StepId step, const BodyAction& action, int threads = 1);

  // A small picture of a step (PNG); empty if there is none.
  Status set_thumbnail(StepId step, const Bytes& png);
  Result<Bytes> thumbnail(StepId step) const;

  // Begins a stroke after the head. Ticks wait in memory until flush(); call it about every 50 ms.
  // Errors of this and of flush and finish: neither the file nor memory is writable. Nothing is
  // lost, and the call can be repeated.
  Status begin(const StrokeSettings& settings, const Pose& start, const std::string& label = {});
  // `computed` is the force by the stroke's own force model. `given` is what the hand's device
  // received from the safety stage. The document stores each of them if every tick of the stroke
  // has one.
  void add(const RecordedTick& tick, const Wrench* computed = nullptr,
           const Wrench* given = nullptr) {
    waiting_.push_back(tick);
    forces_.add(computed);
    given_.add(given);
  }
  bool in_stroke() const { return open_step_ != 0; }
  Status flush();
  // Ends the stroke, which becomes the head. `model` is the model of the stroke's body, without
  // what the stroke severed. `severed` lists the severed pieces that become bodies (take_crumbs).
  Status finish(const TriDexel& model, double removed_mm3,
                const std::vector<Portion>& severed = {}) {
    return finish(model.snapshot(), model.material_bounds(), removed_mm3, severed);
  }
  Status finish(const Snapshot& now, const LatticeBox& material_bounds, double removed_mm3,
                const std::vector<Portion>& severed = {});
  // Removes the stroke. The caller must restore the model to the head's state (go, restore).
  Status cancel();

  // Writes a compact copy into a new file, complete or not at all. The document itself continues in
  // its own file. Errors: an invalid path, or an existing file.
  Status save_copy(const std::filesystem::path& path) const;

  // The settings and the start of a stroke.
  Result<StrokeSettings> settings(StepId step) const;
  Result<Pose> start(StepId step) const;
  // Calls f(ticks of one flush) for all ticks.
  Status for_ticks(StepId step,
                   const std::function<Status(const std::vector<RecordedTick>&)>& f) const;
  // Calls f(forces and moments of the ticks of one flush) for all ticks, if they were stored: see
  // add().
  Status for_forces(StepId step, const std::function<Status(const std::vector<Wrench>&)>& f) const;
  // The same for what the hand's device received.
  Status for_given(StepId step, const std::function<Status(const std::vector<Wrench>&)>& f) const;
  // The action of a step.
  Result<BodyAction> action(StepId step) const;
  // Repeats a stroke or an action on the bench. The bodies on the bench must be in the state before
  // the step (at any pitch). `law` replaces the stroke's force model.
  Status replay(StepId step, Workbench& bench, const std::optional<ForceLaw>& law,
                const std::function<void(const ReplayedTick&)>& use) const;

  // Checks everything: tables, tiles, ticks, and every step by a replay. Calls wrong(sentence) for
  // every problem, note(sentence) for remarks, and progress(share) now and then. Errors: the file
  // cannot be read at all.
  Status verify(const std::function<void(const std::string&)>& wrong,
                const std::function<void(double)>& progress = {},
                const std::function<void(const std::string&)>& note = {}) const;

 private:
  explicit Document(std::unique_ptr<DocumentStorage> storage);
  Error wrong(const std::string& what) const { return Error{name() + ": " + what}; }
  // Like `wrong`, for an error from SQLite.
  Error failed(const std::string& doing, const std::string& reason) const;
  // Opens and locks the file for writing. Writes nothing.
  static Result<std::unique_ptr<Document>> attach(const std::filesystem::path& path,
                                                  const char* vfs);
  // Opens the file for reading, or a private copy of it if a writer's process ended. `log` becomes
  // true if a -wal file exists or a process writes the file.
  static Result<std::unique_ptr<Document>> attach_reader(const std::filesystem::path& path,
                                                         const char* vfs);
  // Returns a sentence about pages that are missing at the end of the file, if its log does not
  // hold them; otherwise empty. Error: a -wal or -journal file next to the document does not belong
  // to it.
  static Result<std::string> check_logs(const std::filesystem::path& path);
  // Opens a private copy of the document and its logs. Errors: those of check_logs; no copy is
  // possible; a process writes the file and `may_be_held` is false.
  static Result<Database> open_copy(const std::filesystem::path& path, bool may_be_held);
  // A sentence that pages are missing at the end of the file; empty if none are.
  static std::string missing_pages(const std::filesystem::path& path);
  // A value of the table `meta`; empty if there is none, or if it is not a document of Kibori.
  static std::string meta_of(Database& database, const char* key);
  // True if the structure and the rows of a database are those of a complete document. The rows of
  // a newer format are not checked.
  static bool is_complete(Database& database);
  Status check_kind();
  bool is_newer() const;  // than the formats that this version reads
  Status check_tables();
  Status read_tree();
  // The first damage on the path to `step`; empty if there is none. row_fault does the same; for
  // the head, it also returns damage() if the number of the head is lost.
  std::string path_fault(StepId step) const;
  std::string row_fault(StepId step) const;
  // Adds a fault of a step (0: of no certain step) that was found when the document was opened.
  void add_damage(StepId step, const std::string& fault);
  Status recover();
  // Applies all of `change` or nothing. If the file is not writable, the document continues in
  // memory.
  Status commit(const char* doing, const std::function<Status()>& change);
  Status try_commit(const char* doing, const std::function<Status()>& change, bool& disk_failed);
  // Within a transaction: seals a finished step, all steps, and the versions.
  Status seal(StepId step);
  Status seal_all();
  Status seal_versions();
  // Calls wrong(step, sentence) for each damaged row; step 0: the row belongs to no certain step.
  Status check_seals(const std::function<void(StepId, const std::string&)>& wrong) const;
  // The same when the document is opened: stores the damage, and reads sealed_blocks_.
  void look_at_seals();
  // Within a transaction: writes the number of this commit into `meta`. So every log contains such
  // a number, which shows to which file the log belongs.
  Status count_commit();
  // While a process writes the file, a mark in it says so. Without the log that must then be next
  // to it, the last steps are missing.
  Status mark(bool writing);
  // For a document without damage: brings its tables up to date.
  Status prepare_writing();
  // For a document that is complete: marks it, and starts the keeper of its log.
  Status begin_writing(const std::filesystem::path& path, const char* vfs);
  Status look_for_log(bool there);
  // Within a transaction. `sequence` becomes the number of the next block once the transaction is
  // committed.
  Status write_ticks(int64_t& sequence);
  Status check_finished(StepId step) const;
  Status for_blocks(BlockTable table, StepId step,
                    const std::function<Status(const Bytes&, int64_t)>& f) const;
  // The tiles to store for the state `now` of a step. These are the tiles that differ from the
  // nearest earlier step with tiles. They are stored in small portions, because this takes time.
  // Their places are written at the end, in one step.
  struct TilePlace {
    int64_t field;  // see field_of
    int tu, tv;
    const Tile* tile;  // null: no material
  };
  struct TileJob {
    StepId step = 0;
    BodyList now;
    LatticeBox bounds;  // of the material of all bodies
    bool planned = false;
    std::vector<TilePlace> places;
    size_t next = 0;
    std::unordered_map<const Tile*, int64_t> ids;
    bool done = false;
  };
  void wait_for_tiles(StepId step, const BodyList& now);
  Status plan_tiles(TileJob& job) const;
  // Within a transaction.
  Status keep_tiles(TileJob& job, std::chrono::steady_clock::time_point until);
  void keep_some_tiles(std::chrono::milliseconds max_time);
  // The tile at each place of a step that has tiles; 0: none. all_tiles returns all places.
  // other_tiles returns those that may differ from the step at the start of `path_from`.
  using Place = std::tuple<int64_t, int64_t, int64_t>;  // field (see field_of), u, v
  using TileMap = std::map<Place, int64_t>;
  Result<TileMap> all_tiles(StepId step) const;
  Result<TileMap> other_tiles(StepId step, const std::vector<StepId>& path_from) const;
  // Writes the tiles of one body into its model.
  Status put_tiles(const TileMap& tiles, StepId step, BodyId body, TriDexel& model) const;
  // The bodies of a step with tiles, in the memory of `work`.
  Result<BodyList> read_tiles(StepId step, TriDexel& work) const;
  // The same from `before`, the bodies of the nearest earlier step with tiles in the same memory.
  // Reads only the tiles of this step.
  Result<BodyList> read_tiles_after(const BodyList& before, StepId step, TriDexel& work) const;
  Result<BodyList> put_bodies(const TileMap& tiles, const BodyList& start, StepId step,
                              const LatticeBox& bounds, TriDexel& work) const;
  // The bodies of any step. `work` becomes the model of its active body.
  Result<BodyList> make_state(TriDexel& work, StepId step) const;
  // Ok if the state of a finished step matches its hash.
  Status check_state(StepId step, const BodyList& now) const;
  // The bodies of a step, from the states in memory and the stored tiles. `work` becomes the model
  // of its active body. Calls remember(step, state) for the states on the path.
  Result<BodyList> rebuild(TriDexel& work, StepId step,
                           const std::function<void(StepId, const BodyList&)>& remember) const;
  // The same for a step with tiles. The state of `work` afterwards is unspecified.
  Result<BodyList> go_by_tiles(TriDexel& work, StepId step) const;
  // The body that strokes act on after a step.
  BodyId active_at(StepId step) const;
  static void take_model(TriDexel& work, const BodyList& bodies, BodyId body);
  void list(StepId step, BodyList bodies);
  // Within a transaction.
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
  // Within a transaction.
  Status write_head(StepId step);
  void remember(StepId step, const BodyList& state);

  const std::unique_ptr<DocumentStorage> storage_;
  std::string unsaved_, missing_;
  std::vector<std::string> damage_;
  std::map<StepId, std::string> broken_;  // steps with damage_
  // Hashes of a step's rows in `tick`, `force` and `given`, from its seal.
  std::map<StepId, std::array<uint64_t, 3>> sealed_blocks_;
  bool head_lost_ = false;         // the file's head is no step that can be read
  bool versions_changed_ = false;  // since they were sealed
  bool writes_ = false;
  bool may_go_to_memory_ = false;
  int64_t version_ = 0;  // of the file's tables
  Lattice lattice_;
  std::map<StepId, Step> steps_;
  std::map<std::string, StepId> versions_;
  std::map<StepId, StepId> last_child_;            // the child that undo left
  std::map<StepId, LatticeBox> checkpoints_;       // with the material's bounds there
  std::unordered_set<StepId> before_checkpoints_;  // steps that a checkpoint follows
  std::deque<TileJob> tiles_;                      // being stored
  LatticeBox material_bounds_;                     // of all states
  StepId head_ = 0, head_in_file_ = 0, open_step_ = 0;
  BodyId active_ = 1;
  std::map<StepId, BodyList> lists_;  // of steps that change the list of bodies; without models
  int64_t open_sequence_ = 0, saved_ticks_ = 0;
  std::vector<RecordedTick> waiting_;
  // Forces of the waiting ticks. `all` is true if every tick of the stroke so far has one.
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
  // The session of this writer, and its number of commits. Empty: commits are not counted.
  std::string session_, before_session_;
  int64_t commits_ = 0;
  // States by step. All share the memory of the current model.
  std::map<StepId, BodyList> states_;
  std::vector<StepId> visited_;
};

}  // namespace kibori
