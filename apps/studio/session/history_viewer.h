// SPDX-License-Identifier: MIT
// A document that is only looked at: it goes to any step, and changes nothing.
#pragma once

#include <optional>

#include "apps/studio/session/session.h"

namespace kibori {

class HistoryViewer final : public Session {
 public:
  // `notice`: what the person is told first.
  static Result<std::unique_ptr<Session>> make(std::unique_ptr<Document> document, Bodies at_head,
                                               const std::string& notice);
  // At the last step that is whole, of a document whose head is not; `why`: what is damaged.
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
  std::optional<Bodies> fresh_;  // that follow() has not seen yet
};

}  // namespace kibori
