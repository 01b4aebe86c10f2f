// SPDX-License-Identifier: MIT
// The WebSocket connection to the studio. After a break it reconnects by itself for a minute. After
// that it reconnects only when the user asks.
import { t } from "../base/texts";
import { entered, key, overNetwork, whyRefused } from "./access";
import { read, write, PROTOCOL_VERSION, type FromStudio } from "./messages";

const FIRST_WAIT_MS = 250,
  LONGEST_WAIT_MS = 8000;
const TRIES_MS = 60000; // after this time without an answer only the user can retry
const GONE = t("gone");
const FULL = t("too_many_windows");
const REFUSED = 1008,
  TOO_MANY = 1013; // the close code that the studio uses

/** One callback for each kind of message from the studio. */
export type Handlers = {
  [Kind in FromStudio["kind"]]: (message: Extract<FromStudio, { kind: Kind }>["message"]) => void;
};

export class Connection {
  private waiting: { kind: FromStudio["kind"]; done: () => void }[] = [];
  private socket: WebSocket | null = null;
  private wait = FIRST_WAIT_MS;
  private lostAt = 0; // [ms]; 0 while connected
  private timer = 0;

  /**
   * Calls `lost` with a text for the user and whether the page reconnects by itself. Calls `lost`
   * with null when the connection is established.
   */
  constructor(
    private handlers: Handlers,
    private lost: (why: { text: string; trying: boolean } | null) => void,
  ) {
    void entered.then(() => this.open());
  }

  send(message: Uint8Array): void {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(message);
  }

  /**
   * Resolves when the studio has handled everything that was sent so far and has reported the state
   * after it. A document must be open.
   */
  async answered(): Promise<void> {
    const heard = this.next("Mass");
    this.send(write.AskMass());
    // A broken connection loses the question, so it is repeated.
    const again = window.setInterval(() => this.send(write.AskMass()), 2000);
    await heard;
    window.clearInterval(again);
    await this.next("State");
  }
  /** Resolves with the next message of this kind. */
  next(kind: FromStudio["kind"]): Promise<void> {
    return new Promise((done) => this.waiting.push({ kind, done }));
  }
  private take({ kind, message }: FromStudio): void {
    (this.handlers[kind] as (message: unknown) => void)(message);
    const due = this.waiting.filter((one) => one.kind === kind);
    this.waiting = this.waiting.filter((one) => one.kind !== kind);
    for (const one of due) one.done();
  }

  /** Closes the connection as if it had broken. For tests. */
  breakOff(): void {
    this.socket?.close();
  }

  /** Reconnects at once, and then keeps trying for a minute. */
  again(): void {
    this.lostAt = performance.now();
    this.wait = FIRST_WAIT_MS;
    this.lost({ text: GONE, trying: true });
    this.open();
  }

  private open(): void {
    window.clearTimeout(this.timer);
    // Drop a connection attempt that is still pending.
    if (this.socket) {
      this.socket.onclose = null;
      this.socket.close();
    }
    const socket = new WebSocket(`${overNetwork ? "wss" : "ws"}://${location.host}/ws`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => socket.send(write.Hello({ version: PROTOCOL_VERSION, key: key() }));
    socket.onmessage = (event) => {
      if (this.lostAt > 0) {
        this.lostAt = 0;
        this.wait = FIRST_WAIT_MS;
        this.lost(null);
      }
      this.take(read(event.data as ArrayBuffer));
    };
    socket.onclose = (event) => this.closed(event.code);
    this.socket = socket;
  }

  private closed(code: number): void {
    const now = performance.now();
    this.lostAt ||= now;
    // The studio was restarted, and asks this device to pair again.
    if (code === REFUSED && overNetwork) return location.reload();
    if (code === REFUSED) return this.lost({ text: whyRefused(), trying: false });
    if (code === TOO_MANY) return this.lost({ text: FULL, trying: false });
    if (now - this.lostAt > TRIES_MS) return this.lost({ text: GONE, trying: false });
    this.lost({ text: GONE, trying: true });
    this.timer = window.setTimeout(() => this.open(), this.wait);
    this.wait = Math.min(LONGEST_WAIT_MS, 2 * this.wait);
  }
}
