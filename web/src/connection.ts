// SPDX-License-Identifier: MIT
// The line to the studio: comes back by itself when it breaks, for a minute, and then when it is asked to.
import { read, write, PROTOCOL_VERSION, type FromStudio } from "./messages";

const FIRST_WAIT_MS = 250, LONGEST_WAIT_MS = 8000;
const ANSWER_MS = 4000; // a studio that is there answers sooner
const TRIES_MS = 60000; // after so long without an answer, only the person tries again
const GONE = "The studio does not answer: it has ended, or this computer slept. Start 'kibori studio' again in a terminal and open the address that it prints.";
const ANEW = "The studio was started anew: open the address it printed in the terminal.";

export class Connection {
  private socket: WebSocket | null = null;
  private wait = FIRST_WAIT_MS;
  private lostAt = 0; // 0: it is there
  private timer = 0;

  /** `lost`: told what to do where the line is broken, and whether it is tried again by itself; null: it is there. */
  constructor(
    private hear: (message: FromStudio) => void,
    private lost: (why: { text: string; trying: boolean } | null) => void,
  ) {
    this.open();
  }

  send(message: Uint8Array): void {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(message);
  }

  /** As if the line had broken. */
  breakOff(): void {
    this.socket?.close();
  }

  /** At once, and then for a minute again. */
  again(): void {
    this.lostAt = performance.now();
    this.wait = FIRST_WAIT_MS;
    this.lost({ text: GONE, trying: true });
    this.open();
  }

  private open(): void {
    window.clearTimeout(this.timer);
    // One that still tries is let go of.
    if (this.socket) {
      this.socket.onclose = null;
      this.socket.close();
    }
    const socket = new WebSocket(`ws://${location.host}/ws`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.lostAt = 0;
      this.wait = FIRST_WAIT_MS;
      this.lost(null);
      socket.send(write.Hello({ version: PROTOCOL_VERSION }));
    };
    socket.onmessage = (event) => this.hear(read(event.data as ArrayBuffer));
    socket.onclose = () => void this.closed(socket);
    this.socket = socket;
  }

  private async closed(socket: WebSocket): Promise<void> {
    const now = performance.now();
    this.lostAt ||= now;
    // A WebSocket does not say why it was refused; the page itself is refused for the same reason.
    const answer = await fetch("/", { cache: "no-store", signal: AbortSignal.timeout(ANSWER_MS) }).catch(() => null);
    if (socket !== this.socket) return; // it was tried anew meanwhile
    if (answer && [401, 403].includes(answer.status)) return this.lost({ text: ANEW, trying: false });
    if (now - this.lostAt > TRIES_MS) return this.lost({ text: GONE, trying: false });
    this.lost({ text: GONE, trying: true });
    this.timer = window.setTimeout(() => this.open(), this.wait);
    this.wait = Math.min(LONGEST_WAIT_MS, 2 * this.wait);
  }
}
