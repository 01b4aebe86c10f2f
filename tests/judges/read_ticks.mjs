// SPDX-License-Identifier: MIT
// Prints the ticks that clients/kibori-ticks.mjs reads, one line of JSON per tick, until kibori
// ends.
// Usage: read_ticks.mjs HOST:PORT
import WebSocket from "ws";
import { listen } from "../../clients/kibori-ticks.mjs";

try {
  for await (const { about, ticks, lost } of listen(process.argv[2], { WebSocket }))
    for (const tick of ticks)
      console.log(JSON.stringify({ ...tick, mode: about.modes[tick.mode], lost }));
} catch (error) {
  console.error(error.message);
  process.exitCode = 2;
}
