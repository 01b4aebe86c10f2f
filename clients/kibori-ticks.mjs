// SPDX-License-Identifier: MIT
// Reads the ticks that kibori servo|studio --publish HOST:PORT sends. For pages, and for Node (before 22 with the package
// ws). Copy this file to where you need it. docs/recordings.md describes the rows.
//
//   import { listen } from "./kibori-ticks.mjs";
//   for await (const { about, ticks } of listen("127.0.0.1:7070"))
//     for (const tick of ticks) console.log(tick.time_s, tick.force_N);

const ABOUT = 96,
  TICKS = 97; // kinds of docs/protocol.md
const FORMAT = 1;
const WAITING = 2 ** 26; // bytes that a reader may leave unread
const BYTES = { u8: 1, u64: 8, i64: 8, f64: 8 };

/** One number of a row. u64 and i64 count ticks and lattice nodes: they fit a number. */
function read(view, type, at) {
  switch (type) {
    case "u8":
      return view.getUint8(at);
    case "u64":
      return Number(view.getBigUint64(at, true));
    case "i64":
      return Number(view.getBigInt64(at, true));
    case "f64":
      return view.getFloat64(at, true);
    default:
      throw new Error(`a column of type ${type}, which is none`);
  }
}

/** The rows of a message of ticks: objects with the columns' names; columns of several numbers are arrays. */
export function decodeTicks(view, about) {
  const ticks = [];
  const length = view.getUint32(1, true);
  for (let row = 0; row + about.row_bytes <= length; row += about.row_bytes) {
    const tick = {};
    for (const { name, type, offset, count } of about.columns) {
      const at = 5 + row + offset;
      tick[name] =
        count === 1
          ? read(view, type, at)
          : Array.from({ length: count }, (_, i) => read(view, type, at + BYTES[type] * i));
    }
    ticks.push(tick);
  }
  return ticks;
}

/**
 * Yields { about, ticks, lost } for each message of ticks: their description, the ticks, and the number of ticks that this
 * reader has missed so far. Ends when kibori ends. Leaving the loop closes the connection.
 * @param {string} address HOST:PORT
 * @param {{ WebSocket?: typeof WebSocket }} options WebSocket: replaces the platform's own, or that of ws if there is none
 */
export async function* listen(address, { WebSocket: Socket = globalThis.WebSocket } = {}) {
  if (!Socket) {
    try {
      Socket = (await import("ws")).WebSocket;
    } catch {
      throw new Error("there is no WebSocket here; install the package ws, or use Node 22");
    }
  }
  const socket = new Socket(`ws://${address}`);
  socket.binaryType = "arraybuffer";
  const received = [];
  let wake = () => {};
  let about = null,
    last = null,
    lost = 0,
    ended = false,
    failed = null;
  let waiting = 0;
  const add = (data) => {
    // The numbers of the ticks show which are missing.
    if (!(data instanceof ArrayBuffer) || data.byteLength === 0) return;
    const view = new DataView(data);
    if (waiting > WAITING && view.getUint8(0) === TICKS) return;
    waiting += data.byteLength;
    received.push(view);
    wake();
  };
  socket.addEventListener("message", ({ data }) => add(data));
  socket.addEventListener(
    "error",
    () =>
      (failed ??= new Error(`nobody publishes ticks at ${address}; start kibori with --publish`)),
  );
  socket.addEventListener("close", () => {
    ended = true;
    wake();
  });
  try {
    for (;;) {
      while (received.length > 0) {
        const view = received.shift();
        waiting -= view.byteLength;
        const kind = view.getUint8(0);
        if (kind === ABOUT) {
          about = JSON.parse(
            new TextDecoder().decode(
              new Uint8Array(view.buffer, view.byteOffset + 7, view.getUint32(3, true)),
            ),
          );
          if (about.format !== FORMAT)
            throw new Error(
              `this kibori publishes in format ${about.format}; this reader knows ${FORMAT}`,
            );
          last = null;
        }
        if (kind !== TICKS || !about) continue;
        const ticks = decodeTicks(view, about);
        for (const { tick } of ticks) {
          if (last !== null && tick > last + 1) lost += tick - last - 1;
          last = tick;
        }
        yield { about, ticks, lost };
      }
      if (ended) break;
      await new Promise((resolve) => (wake = resolve));
    }
    if (failed && !about) throw failed;
  } finally {
    socket.close();
  }
}
