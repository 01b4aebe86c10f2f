// SPDX-License-Identifier: MIT
// A document that is open read-only. The user can go to any step.
#pragma once

#include <optional>

#include "apps/studio/session/session.h"

namespace kibori {

class HistoryViewer final : public Session {
 public:
  // Makes a viewer. `at_head` has the bodies at the head. notice() returns `notice` first.
  static Result<std::unique_ptr<Session>> make(std::unique_ptr<Document> document, BodyList at_head,
                                               const std::string& notice);
  // Opens a document with a damaged head at its last undamaged step. `why` is a sentence about the
  // damage.
  static Result<std::unique_ptr<Session>> at_last_whole(const std::filesystem::path& file,
                                                        std::unique_ptr<Document> damaged,
                                                        const std::string& why);

  void undo() override;
  void redo() override;
  void go(StepId step) override;
  void thumbnail(StepId step, std::function<void(Bytes)> use) override;
  void save_copy(const std::filesystem::path& path, std::function<void(Status)> done) override;

 private:
  HistoryViewer() = default;
  void look_at(const Result<StepId>& step);
  bool latest(Shown& shown) override;
  void update_history() override;

  std::unique_ptr<Document> document_;
  std::optional<BodyList> fresh_;  // bodies that latest() has not returned yet
};

}  // namespace kibori
