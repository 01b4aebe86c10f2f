// SPDX-License-Identifier: MIT
#include <kibori/run/milling.h>

#include <kibori/run/milling_run.h>

namespace kibori {

Result<MillSummary> run_milling(TriDexel& model, const std::vector<std::filesystem::path>& programs,
                                const MillOptions& options) {
  MillRun run(model, options);
  Status done = run.begin();
  for (size_t i = 0; i < programs.size() && done; i++) done = run.run(programs[i]);
  run.end(bool(done));
  if (!done) return Error{done.error()};
  return run.summary();
}

}  // namespace kibori
